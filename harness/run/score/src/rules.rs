//! Rule profiles: the criteria of success, stuck and rollover, as data: `tasks/rules/*.yaml`.

use serde::{Deserialize, Serialize};
use vb_files::{Document, Flaw, Schema};
use vb_record::RunHeader;

/// The reference speed of the time limit, m/s at scale 1: tasks are 120 m long, and the paper's planners take 23 to 28
/// s (table I of the paper).
const PACE: f64 = 5.0;
/// The maximum factor on the time limit of a slower vehicle.
const SLOWEST: f64 = 10.0;

/// A rule profile. Lengths are those of the full-size world and are multiplied by the world's scale when applied; times
/// and speeds by its square root, so that dynamically similar motions of vehicles of different sizes get the same
/// outcome (Froude scaling). An omitted rule never ends a trial.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rules {
    /// Version of the format.
    pub schema: Schema<1>,
    /// The name of the profile.
    pub name: String,
    /// A description in one sentence.
    #[serde(default)]
    pub description: String,
    /// The start of a trial.
    #[serde(default, skip_serializing_if = "StartRule::is_settled")]
    pub start: StartRule,
    /// The condition under which the goal is reached.
    pub success: SuccessRule,
    /// The time limit of a trial, s.
    pub time_limit_s: f64,
    /// The condition under which the vehicle is stuck.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stuck: Option<StuckRule>,
    /// The condition under which a failed trial is a rollover.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rollover: Option<RolloverRule>,
    /// The condition under which the vehicle has left the world.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub out_of_bounds: Option<BoundsRule>,
    /// The condition under which the vehicle has tipped over, which ends the trial at once as a rollover.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub overturned: Option<OverturnedRule>,
}

/// The start of a trial.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum StartRule {
    /// The clock starts with the vehicle at rest on the ground.
    #[default]
    Settled,
    /// The clock starts with the vehicle level and at rest above the ground; it falls while the planner already gives
    /// commands.
    Dropped {
        /// The height of the reference point above the ground there, m. It is increased where the vehicle would
        /// otherwise touch something.
        height_m: f64,
        /// The stretch of the raster from which the ground's height is read: the height is that at the start's
        /// coordinates divided by this number.
        #[serde(default = "unstretched", skip_serializing_if = "is_unstretched")]
        raster_stretch: f64,
    },
}

fn unstretched() -> f64 {
    1.0
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_unstretched(stretch: &f64) -> bool {
    *stretch == 1.0
}

impl StartRule {
    fn is_settled(&self) -> bool {
        *self == Self::Settled
    }
}

/// The condition under which the goal is reached.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum SuccessRule {
    /// The horizontal distance between reference point and goal is less than a radius.
    Planar {
        /// The radius, m.
        radius_m: f64,
    },
    /// The 3D distance between the reference point and a marker above the goal is less than a radius.
    Marker {
        /// The radius, m.
        radius_m: f64,
        /// The height of the marker above the ground at the goal, m.
        marker_height_m: f64,
    },
    /// There is no goal: the trial continues until another rule ends it.
    Never,
}

/// The condition under which the vehicle is stuck.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum StuckRule {
    /// The vehicle is stuck if its 3D position has changed by less than `distance_m` over the last `window_s` seconds.
    Displacement {
        /// The length of the window, s.
        window_s: f64,
        /// The distance, m.
        distance_m: f64,
    },
    /// The vehicle is stuck if it has been slower than `speed_m_per_s` continuously for `duration_s` seconds.
    Slow {
        /// The speed, m/s.
        speed_m_per_s: f64,
        /// The duration, s.
        duration_s: f64,
    },
}

/// The condition under which a failed trial is a rollover.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RolloverRule {
    /// The time at which the angles are evaluated.
    pub when: RollTime,
    /// The limit of |roll|, degrees; a larger angle is a rollover.
    pub roll_limit_deg: f64,
    /// The limit of |pitch|, degrees; a larger angle is a rollover. If omitted, the pitch is ignored.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pitch_limit_deg: Option<f64>,
}

/// The time of a failed trial at which the angles are evaluated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RollTime {
    /// At the end of the trial.
    End,
    /// At any time of the trial.
    AnyTime,
}

/// The condition under which the vehicle has left the world.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BoundsRule {
    /// The permitted distance of the reference point beyond the edge, m.
    pub margin_m: f64,
}

/// The condition under which the vehicle has tipped over.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OverturnedRule {
    /// The limit of the angle between the vehicle's upward axis and the vertical, degrees.
    pub tilt_limit_deg: f64,
}

impl Rules {
    /// The rules of a run, from its header.
    ///
    /// # Errors
    /// Returns an error if a field is missing, unknown or invalid.
    pub fn recorded(header: &RunHeader) -> Result<Self, Flaw> {
        let rules: Self = serde_json::from_value(header.rules.profile.clone())
            .map_err(|e| Flaw::new("rules.profile", e.to_string()))?;
        rules.check()?;
        Ok(rules)
    }

    /// The paper's rules, the default.
    ///
    /// # Panics
    /// Never: the file is part of the program, and tested.
    #[must_use]
    pub fn paper() -> Self {
        Self::resolve("paper").expect("the built-in profile is valid")
    }

    /// The SHA-256 (hex) over the profile's content, which is independent of how the file is laid out.
    ///
    /// # Panics
    /// Never: fields are strings and numbers.
    #[must_use]
    pub fn hash(&self) -> String {
        // Fields come in the order of the struct; all keys are strings and all numbers finite.
        let canonical = serde_json::to_vec(self).expect("rules are plain data");
        vb_files::sha256(&canonical)
    }

    /// Whether each trial ends at the same time under both rules, and as a success under both or neither: they differ
    /// only in the rollover rule and their names.
    #[must_use]
    pub fn end_alike(&self, other: &Self) -> bool {
        let named = |rules: &Self| Self {
            schema: self.schema,
            name: String::new(),
            description: String::new(),
            rollover: None,
            ..rules.clone()
        };
        named(self) == named(other)
    }

    /// The time limit at a scale of the world for a vehicle of a maximum speed (m/s), s. It applies to vehicles that
    /// reach 5 m/s (scaled); slower ones have proportionally more time, at most ten times as much.
    #[must_use]
    pub fn time_limit(&self, scale: f64, max_speed: f64) -> f64 {
        let scaled = scale.sqrt();
        self.time_limit_s * scaled * (PACE * scaled / max_speed).clamp(1.0, SLOWEST)
    }

    /// The radius of the goal at a scale of the world, m; 0 where there is no goal.
    #[must_use]
    pub fn goal_radius(&self, scale: f64) -> f64 {
        match self.success {
            SuccessRule::Planar { radius_m } | SuccessRule::Marker { radius_m, .. } => radius_m * scale,
            SuccessRule::Never => 0.0,
        }
    }

    fn check(&self) -> Result<(), Flaw> {
        let fail = |field: &str, value: String, want: &str| Err(Flaw::must_be(field, value, want));
        if self.name.is_empty() {
            return fail("name", "\"\"".into(), "a name");
        }
        let positive = |field: &str, v: f64| {
            if v.is_finite() && v > 0.0 { Ok(()) } else { fail(field, v.to_string(), "a positive number") }
        };
        let not_negative = |field: &str, v: f64| {
            if v.is_finite() && v >= 0.0 {
                Ok(())
            } else {
                fail(field, v.to_string(), "a number of at least 0")
            }
        };
        let angle = |field: &str, v: f64| {
            if v > 0.0 && v < 180.0 {
                Ok(())
            } else {
                fail(field, v.to_string(), "an angle between 0 and 180 degrees")
            }
        };
        if let StartRule::Dropped { height_m, raster_stretch } = self.start {
            if !(0.5..=2.0).contains(&raster_stretch) {
                let found = raster_stretch.to_string();
                return fail("start.dropped.raster_stretch", found, "a number between 0.5 and 2");
            }
            positive("start.dropped.height_m", height_m)?;
            if height_m > 100.0 {
                return fail("start.dropped.height_m", height_m.to_string(), "at most 100");
            }
        }
        match self.success {
            SuccessRule::Planar { radius_m } => positive("success.planar.radius_m", radius_m)?,
            SuccessRule::Marker { radius_m, marker_height_m } => {
                positive("success.marker.radius_m", radius_m)?;
                not_negative("success.marker.marker_height_m", marker_height_m)?;
                if marker_height_m >= radius_m {
                    return fail(
                        "success.marker.marker_height_m",
                        marker_height_m.to_string(),
                        "less than the radius, else the goal can't be reached",
                    );
                }
            }
            SuccessRule::Never => {}
        }
        positive("time_limit_s", self.time_limit_s)?;
        if self.time_limit_s > 3600.0 {
            return fail("time_limit_s", self.time_limit_s.to_string(), "at most 3600");
        }
        match self.stuck {
            Some(StuckRule::Displacement { window_s, distance_m }) => {
                positive("stuck.displacement.window_s", window_s)?;
                positive("stuck.displacement.distance_m", distance_m)?;
            }
            Some(StuckRule::Slow { speed_m_per_s, duration_s }) => {
                positive("stuck.slow.speed_m_per_s", speed_m_per_s)?;
                positive("stuck.slow.duration_s", duration_s)?;
            }
            None => {}
        }
        if let Some(rule) = self.rollover {
            angle("rollover.roll_limit_deg", rule.roll_limit_deg)?;
            if let Some(limit) = rule.pitch_limit_deg {
                angle("rollover.pitch_limit_deg", limit)?;
            }
        }
        if let Some(rule) = self.out_of_bounds {
            not_negative("out_of_bounds.margin_m", rule.margin_m)?;
        }
        if let Some(rule) = self.overturned {
            angle("overturned.tilt_limit_deg", rule.tilt_limit_deg)?;
        }
        Ok(())
    }
}

impl Document for Rules {
    type File = Self;
    const KIND: &'static str = "rules";
    const FIELDS: &'static str = "docs/scoring.md";
    const BUILTIN: &'static [(&'static str, &'static str)] = &[
        ("paper", include_str!("../../../../tasks/rules/paper.yaml")),
        ("release", include_str!("../../../../tasks/rules/release.yaml")),
        ("dev", include_str!("../../../../tasks/rules/dev.yaml")),
        ("exploration", include_str!("../../../../tasks/rules/exploration.yaml")),
        ("training", include_str!("../../../../tasks/rules/training.yaml")),
    ];

    fn from_file(rules: Self) -> Result<Self, Flaw> {
        rules.check()?;
        Ok(rules)
    }
}

vb_files::document!(Rules);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_built_in_profiles_hold_the_published_rules() {
        // Paper as described, released code, evaluation scripts: docs/scoring.md says where each comes from.
        let paper = Rules::paper();
        assert_eq!(paper.success, SuccessRule::Planar { radius_m: 10.0 });
        assert_eq!(paper.time_limit_s, 60.0);
        assert_eq!(paper.stuck, Some(StuckRule::Displacement { window_s: 10.0, distance_m: 1.0 }));
        let limit = RolloverRule { when: RollTime::End, roll_limit_deg: 30.0, pitch_limit_deg: None };
        assert_eq!(paper.rollover, Some(limit));
        let release = Rules::resolve("release").unwrap();
        assert_eq!(release.success, SuccessRule::Marker { radius_m: 8.0, marker_height_m: 2.0 });
        assert_eq!(release.stuck, Some(StuckRule::Slow { speed_m_per_s: 0.01 / 0.005, duration_s: 10.0 }));
        assert_eq!((release.rollover, release.out_of_bounds), (None, None));
        // The original's vehicles/HMMWV.py: level, the reference point 1 m above the ground, and the loop runs from
        // there.
        assert_eq!(release.start, StartRule::Dropped { height_m: 1.0, raster_stretch: 129.0 / 128.0 });
        assert_eq!(paper.start, StartRule::Settled);
        let dev = Rules::resolve("dev").unwrap();
        assert_eq!(dev.rollover.unwrap().when, RollTime::AnyTime);
        for (name, _) in Rules::BUILTIN {
            assert_eq!(Rules::resolve(name).unwrap().name, *name);
        }
    }

    #[test]
    fn the_hash_follows_the_content_not_the_layout() {
        let text = Rules::BUILTIN[0].1;
        let spaced = format!("# another comment\n{}", text.replace("10.0", "10"));
        assert_eq!(Rules::parse(&spaced, "a").unwrap().hash(), Rules::paper().hash());
        let other = Rules::parse(&text.replace("60.0", "61.0"), "a").unwrap();
        assert_ne!(other.hash(), Rules::paper().hash());
    }

    #[test]
    fn a_start_on_the_ground_is_the_default_and_a_drop_is_another_profile() {
        let text = Rules::BUILTIN[0].1;
        let with = |start: &str| Rules::parse(&format!("{text}\nstart: {start}\n"), "a");
        assert_eq!(with("settled").unwrap().hash(), Rules::paper().hash());
        let dropped = with("{dropped: {height_m: 0.5}}").unwrap();
        assert_eq!(dropped.start, StartRule::Dropped { height_m: 0.5, raster_stretch: 1.0 });
        assert_ne!(dropped.hash(), Rules::paper().hash());
        let e = with("{dropped: {height_m: -1}}").unwrap_err().to_string();
        assert!(e.contains("start.dropped.height_m: -1 must be a positive number"), "{e}");
        let e = with("{dropped: {height_m: 1, raster_stretch: 0}}").unwrap_err().to_string();
        assert!(e.contains("start.dropped.raster_stretch: 0 must be a number between 0.5 and 2"), "{e}");
        assert!(with("flying").unwrap_err().to_string().contains("flying"));
    }

    fn error(change: fn(&str) -> String) -> String {
        let e = Rules::parse(&change(Rules::BUILTIN[0].1), "my.yaml").unwrap_err().to_string();
        assert!(e.starts_with("my.yaml: ") && !e.contains('\n'), "{e}");
        e
    }

    #[test]
    fn a_bad_rule_file_is_refused_with_file_field_and_value() {
        let e = error(|t| t.replace("time_limit_s: 60.0", "time_limit_s: soon"));
        assert!(e.contains("time_limit_s: \"soon\"") && e.contains("line 10"), "{e}");
        let e = error(|t| t.replace("radius_m: 10.0", "radius_m: -3"));
        assert!(e.contains("success.planar.radius_m: -3 must be a positive number"), "{e}");
        let e = error(|t| t.replace("radius_m: 10.0", "radius_m: .nan"));
        assert!(e.contains("success.planar.radius_m: NaN"), "{e}");
        let e = error(|t| t.replace("window_s", "windows"));
        assert!(e.contains("stuck.displacement") && e.contains("windows"), "{e}");
        let e = error(|t| t.replace("  displacement:", "  teleport:"));
        assert!(e.contains("teleport"), "{e}");
        let e = error(|t| t.replace("time_limit_s: 60.0", ""));
        assert!(e.contains("time_limit_s"), "{e}");
        let e = error(|t| t.replace("schema: 1", "schema: 2"));
        assert!(e.contains("schema: ") && e.contains("version 2 is not supported"), "{e}");
        let e = error(|t| t.replace("roll_limit_deg: 30.0", "roll_limit_deg: 300"));
        assert!(e.contains("rollover.roll_limit_deg: 300"), "{e}");
        let e = error(|_| "a: [1".into());
        assert!(e.contains("my.yaml"), "{e}");
        let e = error(|_| String::new());
        assert!(e.contains("my.yaml"), "{e}");
    }

    #[test]
    fn a_missing_rule_file_is_an_error_that_names_the_profiles() {
        let e = Rules::resolve("papper").unwrap_err().to_string();
        assert!(e.contains("papper") && e.contains("paper, release, dev, exploration"), "{e}");
    }
}
