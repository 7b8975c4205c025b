//! The macro that makes a plugin of a policy's weights.

/// Exports a policy whose weights are in a file as a plugin of its own.
///
/// `weights` are the bytes of a file that `python -m vertibench.training export` has written, which is read when a task begins;
/// `model` is a constant text that tells where they come from, for the plugin's metadata. A policy that sees what takes a sensor
/// beside the pose is written by hand, with [`Trained`](crate::policy::Trained) and [`export_planner!`](crate::export_planner).
///
/// ```
/// vb_sdk::export_policy! {
///     name: "hill-fox",
///     about: "Has learned to drive over hills",
///     weights: b"vb-nn: 1\n\n",
///     model: "none yet",
/// }
/// ```
#[macro_export]
macro_rules! export_policy {
    (name: $name:literal, about: $about:literal, weights: $weights:expr, model: $model:expr $(,)?) => {
        $crate::export_planner! {
            planner: Policy,
            name: $name,
            about: $about,
            control_period: 0.1,
            models: [$model],
        }

        /// The planner: a policy by its weights.
        pub struct Policy {
            task: $crate::Task,
            policy: $crate::policy::Trained,
        }

        impl $crate::Planner for Policy {
            fn init(task: &$crate::Task) -> Result<Self, $crate::PlannerError> {
                let policy = $crate::policy::Trained::new(&$crate::nn::Weights::parse($weights)?, task)?;
                Ok(Self { task: task.clone(), policy })
            }

            fn step(
                &mut self,
                observation: &$crate::Observation,
            ) -> Result<$crate::Command, $crate::PlannerError> {
                self.policy.step(&self.task, observation)
            }
        }
    };
}
