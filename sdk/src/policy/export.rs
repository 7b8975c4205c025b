//! The macro that exports a policy's weights as a plugin.

/// Exports a policy with an embedded weights file as a plugin.
///
/// `weights` are the bytes of a file from `python -m vertibench.training export`, parsed at the start of a task;
/// `model` is a constant text with their origin, for the plugin's metadata. A policy that observes a sensor other than
/// the pose needs a custom planner with [`Trained`](crate::policy::Trained) and
/// [`export_planner!`](crate::export_planner).
///
/// ```
/// vb_sdk::export_policy! {
///     name: "hill-fox",
///     about: "End-to-end policy, trained on hills",
///     weights: b"vb-nn: 1\n\n",
///     model: "none",
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

        /// The planner: a policy with its weights.
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
