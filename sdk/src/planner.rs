//! The planner trait.

use std::fmt;
use std::str::FromStr;

use crate::{Command, Gear, HeightMap, LabelMap, LocalMap, Observation, Pose, Task};

/// A planner for one task. Implement this trait and export the planner with [`export_planner!`](crate::export_planner).
///
/// The inputs of a planner are the task and its observations: it has no clock, files or network. For random numbers,
/// seed [`rng::Rng`](crate::rng::Rng) with [`Task::seed`].
pub trait Planner: Sized + 'static {
    /// Prepares the planner for a task. Called once, before the first step.
    ///
    /// # Errors
    /// An error ends the task with the outcome `planner_error` and the error's text.
    fn init(task: &Task) -> Result<Self, PlannerError>;

    /// Returns a command. Called every control period, first at time 0; the command holds until the next call.
    ///
    /// # Errors
    /// An error ends the task with the outcome `planner_error` and the error's text.
    fn step(&mut self, observation: &Observation) -> Result<Command, PlannerError>;
}

/// The reason why a planner aborts a task: a text for the user.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlannerError(String);

impl PlannerError {
    /// Creates an error with this text.
    pub fn new(message: impl fmt::Display) -> Self {
        Self(message.to_string())
    }
}

impl fmt::Display for PlannerError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for PlannerError {}

impl From<String> for PlannerError {
    fn from(message: String) -> Self {
        Self(message)
    }
}

impl From<&str> for PlannerError {
    fn from(message: &str) -> Self {
        Self(message.to_owned())
    }
}

impl Command {
    /// The clamped command, with steering in [-1, 1] and throttle and brake in [0, 1], and whether any value was out of
    /// range.
    #[must_use]
    pub fn clamped(self) -> (Self, bool) {
        let Self { steering, throttle, brake, .. } = self;
        let limited = Self {
            steering: steering.clamp(-1.0, 1.0),
            throttle: throttle.clamp(0.0, 1.0),
            brake: brake.clamp(0.0, 1.0),
            ..self
        };
        let changed = (limited.steering, limited.throttle, limited.brake) != (steering, throttle, brake);
        (limited, changed)
    }
}

impl Gear {
    /// The direction of travel: 1 forward, 0 in neutral, -1 in reverse.
    #[must_use]
    pub fn direction(self) -> f64 {
        match self {
            Self::Forward => 1.0,
            Self::Neutral => 0.0,
            Self::Reverse => -1.0,
        }
    }
}

impl Observation {
    /// An observation with only this pose, for tests of planners.
    #[must_use]
    pub fn of(pose: Pose) -> Self {
        Self { pose: Some(pose), ..Self::default() }
    }

    /// The estimate of the vehicle's state.
    ///
    /// # Errors
    /// Returns an error if the pose is absent: the planner does not request it, or requests it with a lower rate than
    /// its steps.
    pub fn pose(&self) -> Result<&Pose, PlannerError> {
        self.pose.as_ref().ok_or_else(|| "this observation has no pose; request `pose` in every step".into())
    }

    /// The local map.
    ///
    /// # Errors
    /// Returns an error if the local map is absent: the planner does not request it, or requests it with a lower rate
    /// than its steps.
    pub fn local_map(&self) -> Result<&LocalMap, PlannerError> {
        self.local_map
            .as_ref()
            .ok_or_else(|| "this observation has no local map; request `local-map` in every step".into())
    }
}

impl Task {
    /// The elevation map.
    ///
    /// # Errors
    /// Returns an error if the perception profile omits it.
    pub fn elevation(&self) -> Result<&HeightMap, PlannerError> {
        self.elevation.as_ref().ok_or_else(|| self.lacks("elevation map"))
    }

    /// The map of terrain classes.
    ///
    /// # Errors
    /// Returns an error if the perception profile omits it.
    pub fn semantics(&self) -> Result<&LabelMap, PlannerError> {
        self.semantics.as_ref().ok_or_else(|| self.lacks("map of terrain classes"))
    }

    /// The occupancy map.
    ///
    /// # Errors
    /// Returns an error if the perception profile omits it.
    pub fn occupancy(&self) -> Result<&LabelMap, PlannerError> {
        self.occupancy.as_ref().ok_or_else(|| self.lacks("occupancy map"))
    }

    fn lacks(&self, map: &str) -> PlannerError {
        PlannerError(format!("the perception profile `{}` omits the {map}", self.perception))
    }

    /// The value of a parameter as text; `None` if the planner does not declare it.
    #[must_use]
    pub fn param(&self, key: &str) -> Option<&str> {
        self.params.iter().find(|p| p.key == key).map(|p| p.value.as_str())
    }

    /// The value of a parameter, parsed as a `T`.
    ///
    /// # Errors
    /// Returns an error if the planner does not declare the parameter, or the value is not a `T`.
    pub fn param_as<T: FromStr>(&self, key: &str) -> Result<T, PlannerError> {
        let value = self
            .param(key)
            .ok_or_else(|| PlannerError(format!("parameter `{key}` is not declared in export_planner!")))?;
        value.trim().parse().map_err(|_| {
            let wanted = kind_of(std::any::type_name::<T>());
            PlannerError(format!("parameter `{key}`: `{value}` is not {wanted}"))
        })
    }

    /// The value of a parameter as a finite number.
    ///
    /// # Errors
    /// Returns an error if the planner does not declare the parameter, or the value is not a finite number.
    pub fn param_f64(&self, key: &str) -> Result<f64, PlannerError> {
        let value: f64 = self.param_as(key)?;
        if value.is_finite() {
            Ok(value)
        } else {
            Err(PlannerError(format!("parameter `{key}`: {value} is not a finite number")))
        }
    }

    /// The value of a parameter as a finite positive number, e.g. a speed or a length.
    ///
    /// # Errors
    /// Returns an error if the planner does not declare the parameter, or the value is not a finite positive number.
    pub fn param_positive(&self, key: &str) -> Result<f64, PlannerError> {
        match self.param_f64(key)? {
            value if value > 0.0 => Ok(value),
            value => Err(PlannerError(format!("parameter `{key}`: {value} is not above 0"))),
        }
    }
}

/// The values of a type, in words.
fn kind_of(type_name: &str) -> String {
    match type_name {
        "f64" | "f32" => "a number".to_owned(),
        "u8" | "u16" | "u32" | "u64" | "usize" => "a whole number that is not below 0".to_owned(),
        "i8" | "i16" | "i32" | "i64" | "isize" => "a whole number".to_owned(),
        "bool" => "true or false".to_owned(),
        other => format!("a value of type {other}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Param;

    fn task(value: &str) -> Task {
        Task { params: vec![Param { key: "speed".into(), value: value.into() }], ..Task::default() }
    }

    #[test]
    fn commands_out_of_range_are_clamped_and_told() {
        let command = |steering, throttle, brake| Command { steering, throttle, brake, ..Command::default() };
        assert_eq!(command(-1.0, 1.0, 0.0).clamped(), (command(-1.0, 1.0, 0.0), false));
        assert_eq!(command(1.5, 0.5, 0.0).clamped(), (command(1.0, 0.5, 0.0), true));
        assert_eq!(command(-7.0, -0.1, 2.0).clamped(), (command(-1.0, 0.0, 1.0), true));
    }

    #[test]
    fn gears_have_the_sign_of_the_direction_of_travel() {
        assert_eq!([Gear::Forward, Gear::Neutral, Gear::Reverse].map(Gear::direction), [1.0, 0.0, -1.0]);
    }

    #[test]
    fn a_declared_parameter_is_parsed() {
        assert_eq!(task(" 4.5 ").param_f64("speed"), Ok(4.5));
        assert_eq!(task("7").param_as::<u32>("speed"), Ok(7));
        assert_eq!(task("x").param("speed"), Some("x"));
    }

    #[test]
    fn a_bad_parameter_names_itself_and_its_value() {
        for (value, key) in [("fast", "speed"), ("NaN", "speed"), ("inf", "speed"), ("1", "lookahead")] {
            let message = task(value).param_f64(key).unwrap_err().to_string();
            assert!(message.contains(&format!("`{key}`")), "{message}");
        }
        let said = |wrong: Result<String, PlannerError>| wrong.unwrap_err().to_string();
        let number = task("fast").param_f64("speed").map(|v| v.to_string());
        assert_eq!(said(number), "parameter `speed`: `fast` is not a number");
        let whole = task("1.5").param_as::<u32>("speed").map(|v| v.to_string());
        assert_eq!(said(whole), "parameter `speed`: `1.5` is not a whole number that is not below 0");
        for value in ["0", "-2"] {
            let message = task(value).param_positive("speed").unwrap_err().to_string();
            assert_eq!(message, format!("parameter `speed`: {value} is not above 0"));
        }
    }
}
