//! What is said of a run beside the view: with what it was driven, and why it ended.

use vb_score::{Outcome, RollTime, Rules, StuckRule, SuccessRule};

use crate::ReplayRun;

/// A number without superfluous digits.
fn short(v: f64) -> String {
    let text = format!("{v:.2}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// A scale as people write it.
fn ratio(scale: f64) -> String {
    let inverse = 1.0 / scale;
    if (inverse - inverse.round()).abs() < 1e-9 && scale < 1.0 {
        format!("1:{inverse:.0}")
    } else {
        format!("{}:1", short(scale))
    }
}

/// The rule that decides for an outcome in a world of a scale and a vehicle of a maximum speed (m/s), in words; none where no rule did.
fn rule(rules: &Rules, outcome: Outcome, scale: f64, max_speed: f64) -> Option<String> {
    let pace = scale.sqrt();
    let rollover = || {
        let by_angle = rules.rollover.map(|r| {
            let pitch = r
                .pitch_limit_deg
                .map_or_else(String::new, |p| format!(", or a pitch of more than {}°", short(p)));
            let when = match r.when {
                RollTime::End => "at its end",
                RollTime::AnyTime => "at any time",
            };
            format!("a failed trial with a roll of more than {}°{pitch} {when}", short(r.roll_limit_deg))
        });
        let by_tilt = rules.overturned.map(|r| format!("a tilt of more than {}°", short(r.tilt_limit_deg)));
        let all: Vec<String> = by_tilt.into_iter().chain(by_angle).collect();
        (!all.is_empty()).then(|| all.join("; or "))
    };
    match outcome {
        Outcome::Success => match rules.success {
            SuccessRule::Planar { .. } => Some(format!(
                "within {} m of the goal in the horizontal plane",
                short(rules.goal_radius(scale))
            )),
            SuccessRule::Marker { marker_height_m, .. } => Some(format!(
                "within {} m of the point {} m above the goal",
                short(rules.goal_radius(scale)),
                short(marker_height_m * scale)
            )),
            SuccessRule::Never => None,
        },
        Outcome::Stuck => rules.stuck.map(|stuck| match stuck {
            StuckRule::Displacement { window_s, distance_m } => {
                format!("moved less than {} m within {} s", short(distance_m * scale), short(window_s * pace))
            }
            StuckRule::Slow { speed_m_per_s, duration_s } => {
                format!("slower than {} m/s for {} s", short(speed_m_per_s * pace), short(duration_s * pace))
            }
        }),
        Outcome::Rollover => rollover(),
        Outcome::Timeout => {
            Some(format!("goal not reached within {} s", short(rules.time_limit(scale, max_speed))))
        }
        Outcome::OutOfBounds => rules.out_of_bounds.map(|r| match r.margin_m * scale {
            0.0 => "outside the world".to_owned(),
            margin => format!("more than {} m outside the world", short(margin)),
        }),
        Outcome::PlannerError | Outcome::SimError | Outcome::HostError => None,
    }
}

/// Terms with what is said of them, in the order in which they are shown; texts as they are.
pub(crate) fn facts(run: &ReplayRun, scale: f64) -> Vec<(&'static str, String)> {
    let record = &run.record;
    let mut facts = vec![("outcome", record.outcome.name().replace('_', " "))];
    if let Some(text) =
        run.rules.as_ref().and_then(|rules| rule(rules, record.outcome, scale, run.vehicle.max_speed))
    {
        facts.push(("rule", text));
    }
    facts.push(("reason", record.reason.clone()));
    if let Some(cause) = record.cause {
        facts.push(("cause", cause.title().to_owned()));
    }
    if !record.evidence.is_empty() {
        facts.push(("evidence", record.evidence.clone()));
    }
    if let Some(fault) = &record.fault {
        facts.push(("fault", fault.to_string()));
    }
    let spec = &run.vehicle;
    facts.push(("vehicle", format!("{}: {}", spec.name, spec.description)));
    facts.push(("scale", ratio(scale)));
    if let Some(rules) = &run.rules {
        let about =
            if rules.description.is_empty() { String::new() } else { format!(": {}", rules.description) };
        facts.push(("rules", format!("{}{about}", rules.name)));
    }
    facts
}

#[cfg(test)]
mod tests {
    use super::*;

    fn built_in(name: &str) -> Rules {
        let (_, text) = Rules::BUILTIN.iter().find(|(n, _)| *n == name).unwrap();
        Rules::parse(text, name).unwrap()
    }

    #[test]
    fn the_rule_that_decided_is_said_at_the_scale_of_the_world() {
        // tasks/rules/paper.yaml: 10 m, 60 s, 1 m in 10 s, 30° at the end, 0 m of margin.
        let paper = built_in("paper");
        let said = |outcome, scale| rule(&paper, outcome, scale, 30.0).unwrap();
        assert_eq!(said(Outcome::Success, 1.0), "within 10 m of the goal in the horizontal plane");
        assert_eq!(said(Outcome::Stuck, 1.0), "moved less than 1 m within 10 s");
        assert_eq!(said(Outcome::Timeout, 1.0), "goal not reached within 60 s");
        assert_eq!(said(Outcome::OutOfBounds, 1.0), "outside the world");
        assert_eq!(said(Outcome::Rollover, 1.0), "a failed trial with a roll of more than 30° at its end");
        // Lengths shrink by 4, and times by its root.
        assert_eq!(said(Outcome::Stuck, 0.25), "moved less than 0.25 m within 5 s");
        assert_eq!(said(Outcome::Timeout, 0.25), "goal not reached within 30 s");
        assert_eq!(rule(&paper, Outcome::PlannerError, 1.0, 30.0), None, "no rule, but a fault");
        let dev = built_in("dev");
        let text = "a failed trial with a roll of more than 30°, or a pitch of more than 30° at any time";
        assert_eq!(rule(&dev, Outcome::Rollover, 1.0, 30.0).unwrap(), text);
        assert_eq!(
            rule(&dev, Outcome::Success, 0.1, 30.0).unwrap(),
            "within 1 m of the point 0.2 m above the goal"
        );
    }

    #[test]
    fn scales_are_written_as_ratios() {
        assert_eq!([1.0, 1.0 / 6.0, 0.1, 2.0].map(ratio), ["1:1", "1:6", "1:10", "2:1"]);
    }
}
