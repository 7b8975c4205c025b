//! Macros that export the hybrid planners as plugins.

/// Exports a variant of [`Hybrid`](crate::Hybrid) as a plugin: planner type, name, description, aim, prediction model,
/// and the parameters with their own defaults. All variants share the other parameters.
#[macro_export]
macro_rules! export_hybrid {
    (
        planner: $planner:ident,
        name: $name:literal,
        about: $about:literal,
        aim: $aim:ident,
        learned: $learned:ident,
        attention: $attention:literal,
        params: { $($own:tt)* },
    ) => {
        $crate::export_sampling! {
            planner: $planner,
            name: $name,
            about: $about,
            attention: $attention,
            samples: 500,
            params: { $($own)* },
        }

        /// The planner.
        pub struct $planner($crate::Hybrid);

        impl vb_sdk::Planner for $planner {
            fn init(task: &vb_sdk::Task) -> Result<Self, vb_sdk::PlannerError> {
                let prediction = $crate::Prediction { learned: $crate::Learned::$learned, attention: $attention };
                $crate::Hybrid::new(task, $crate::Aim::$aim, prediction).map(Self)
            }

            fn step(&mut self, o: &vb_sdk::Observation) -> Result<vb_sdk::Command, vb_sdk::PlannerError> {
                self.0.step(o)
            }
        }
    };
}

/// Exports a planner that contains a [`Hybrid`](crate::Hybrid) as a plugin: name, description, whether the networks use
/// attention, rollouts per period, additional parameters, and the data required by tasks without maps.
#[macro_export]
macro_rules! export_sampling {
    (
        planner: $planner:ident,
        name: $name:literal,
        about: $about:literal,
        attention: $attention:literal,
        samples: $samples:literal,
        params: { $($own:tt)* }
        $(, without_maps: { $($more:tt)* })? $(,)?
    ) => {
        vb_sdk::export_planner! {
            planner: $planner,
            name: $name,
            about: $about,
            control_period: 0.1,
            params: {
                speed: 4.0 => "target speed, m/s at full scale",
                $($own)*
                samples: $samples => "rollouts per control period",
                horizon: 20 => "steps per rollout, of 0.2 s at full scale",
                spacing: 5 => "spacing of sampled commands, steps; linear in between",
                speed_spread: 1.0 => "standard deviation of sampled speeds, m/s at full scale",
                obstacle: 10.0 => "weight of obstacles and world edges",
                margin: 1.0 => "distance from obstacles above which they have no cost, m at full scale",
                pace: 0.5 => "weight of the deviation from the target speed",
                effort: 0.2 => "weight of steering",
                roll: 12.0 => "roll angle up to which it has no cost, degrees",
                pitch: 15.0 => "pitch angle up to which it has no cost, degrees",
                learned: 1 => "1: learned model; 0: kinematic bicycle on the plane through its wheels",
                explain: 0 => "number of rollouts (rounded up to a multiple of 8) to record with their costs in the debug file",
            }
            $(, without_maps: { $($more)* })?,
            models: [if $attention { $crate::ATTENTION_MODELS } else { $crate::PATCH_MODELS }],
        }
    };
}
