//! What the plugins of the hybrid planners are made of.

/// Makes a plugin of a variant of [`Hybrid`](crate::Hybrid): its planner, its name, what it does, its aim, what it predicts by,
/// and the parameters whose defaults are its own. All variants share the others.
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

/// Makes a plugin of a planner that has a [`Hybrid`](crate::Hybrid): its name, what it does, whether its networks pay attention,
/// how many courses it draws, the parameters that it has beside those of all, and what it asks for where there are no maps, if anything.
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
                samples: $samples => "courses drawn every control period",
                horizon: 20 => "steps of a course, of 0.2 s at full scale",
                spacing: 5 => "steps from one drawn command to the next; those between lie on a line",
                speed_spread: 1.0 => "standard deviation of drawn speed, m/s at full scale",
                obstacle: 10.0 => "weight of obstacles and edges",
                margin: 1.0 => "distance between vehicle and obstacle that costs nothing, m at full scale",
                pace: 0.5 => "weight of the deviation from the target speed",
                effort: 0.2 => "weight of steering",
                roll: 12.0 => "roll that costs nothing, degrees",
                pitch: 15.0 => "pitch that costs nothing, degrees",
                learned: 1 => "whether the networks have a say; 0 for a bicycle on the plane through its wheels",
                explain: 0 => "number of courses (rounded up to a multiple of 8) to record with their costs beside the trajectory",
            }
            $(, without_maps: { $($more)* })?,
            models: [if $attention { $crate::ATTENTION_MODELS } else { $crate::PATCH_MODELS }],
        }
    };
}
