//! `probes`: observations that no simulation should make don't take the planner out of control. It may answer, or give
//! up with an error; it must not loop, crash, or eat memory.

use std::collections::BTreeMap;

use vb_host::{FaultCode, LogSink, Plugin};
use vb_sdk::{Observation, Param, Pose, Vec3, Wheel};

use super::course::Course;
use super::report::{Check, Verdict};
use super::{KitError, planners_own};

const NAME: &str = "probes";
/// How often each observation is shown, with a sound one before and after.
const TIMES: usize = 3;

pub(super) fn check(course: &Course, plugin: &Plugin, params: &[Param]) -> Result<Check, KitError> {
    let brief = course.brief(0, plugin, params)?;
    let sound = Observation {
        pose: Some(Pose {
            position: Vec3 { x: brief.start.x, y: brief.start.y, z: 1.0 },
            yaw: brief.start.yaw,
            ..Pose::default()
        }),
        wheels: vec![Wheel::default(); brief.vehicle.wheels as usize],
        ..Observation::default()
    };
    let mut seen = Vec::new();
    for (name, extreme) in extremes(&sound) {
        let mut session = match plugin.start(&brief, LogSink::discard()) {
            Ok(session) => session,
            Err(fault) => {
                planners_own(fault)?;
                return Ok(Check::skip(NAME, "it doesn't start"));
            }
        };
        if let Err(fault) = session.step(&sound) {
            planners_own(fault)?;
            return Ok(Check::skip(NAME, "it fails at the first step"));
        }
        let last =
            Observation { time: sound.time + brief.control_period * (TIMES + 1) as f64, ..sound.clone() };
        let shown = std::iter::repeat_n(&extreme, TIMES).chain([&last]);
        let fault = shown.map(|o| session.step(o)).find_map(Result::err);
        seen.push((name, fault.map(planners_own).transpose()?.map(|f| f.code())));
    }
    Ok(judge(&seen))
}

/// How a planner that was shown something extreme ended, if it did.
fn verdict(code: FaultCode) -> Verdict {
    match code {
        // Its own decision.
        FaultCode::Error => Verdict::Pass,
        // The end of the task, but an orderly one.
        FaultCode::Panic | FaultCode::Trap | FaultCode::InvalidOutput => Verdict::Warn,
        _ => Verdict::Fail,
    }
}

fn judge(seen: &[(&'static str, Option<FaultCode>)]) -> Check {
    let ended = |wanted: Verdict| {
        let mut of = BTreeMap::<FaultCode, Vec<&str>>::new();
        for (name, code) in seen.iter().filter_map(|(name, code)| code.map(|code| (*name, code))) {
            if verdict(code) == wanted {
                of.entry(code).or_default().push(name);
            }
        }
        let texts = of.iter().map(|(code, names)| format!("{code} after {}", names.join(", ")));
        texts.collect::<Vec<_>>().join("; ")
    };
    let (lost, orderly) = (ended(Verdict::Fail), ended(Verdict::Warn));
    if !lost.is_empty() {
        return Check::fail(NAME, lost, "limit every loop and allocation, for any observation");
    }
    if !orderly.is_empty() {
        return Check::warn(
            NAME,
            orderly,
            "return an error for invalid observations, with a text that names the value",
        );
    }
    Check::pass(NAME, format!("{} extreme observations, each with a command or an error", seen.len()))
}

/// Observations that sound code survives, by name.
fn extremes(sound: &Observation) -> Vec<(&'static str, Observation)> {
    /// The same value wherever there is one.
    fn filled(sound: &Observation, x: f64) -> Observation {
        let all = Vec3 { x, y: x, z: x };
        Observation {
            time: sound.time,
            pose: Some(Pose {
                position: all,
                roll: x,
                pitch: x,
                yaw: x,
                linear_velocity: all,
                angular_velocity: all,
            }),
            wheels: vec![Wheel { spin: x, travel: x }; sound.wheels.len()],
            engine_speed: x,
            last_steering: x,
            last_throttle: x,
            last_brake: x,
            ..sound.clone()
        }
    }
    let with = |change: &dyn Fn(&mut Observation)| {
        let mut o = sound.clone();
        change(&mut o);
        o
    };
    fn pose(o: &mut Observation) -> &mut Pose {
        o.pose.get_or_insert_default()
    }
    vec![
        ("zeros", filled(sound, 0.0)),
        ("negative zeros", filled(sound, -0.0)),
        ("NaN", filled(sound, f64::NAN)),
        ("infinity", filled(sound, f64::INFINITY)),
        ("negative infinity", filled(sound, f64::NEG_INFINITY)),
        ("maximum numbers", filled(sound, f64::MAX)),
        ("minimum numbers", filled(sound, f64::MIN)),
        ("denormal numbers", filled(sound, f64::from_bits(1))),
        ("NaN for the position only", with(&|o| pose(o).position.x = f64::NAN)),
        ("NaN for the heading only", with(&|o| pose(o).yaw = f64::NAN)),
        ("a heading of a million turns", with(&|o| pose(o).yaw = 6.3e6)),
        ("a position far outside the world", with(&|o| pose(o).position.x = 1e9)),
        ("no pose", with(&|o| o.pose = None)),
        ("no wheels", with(&|o| o.wheels.clear())),
        ("a thousand wheels", with(&|o| o.wheels = vec![Wheel::default(); 1000])),
        ("a constant time", with(&|_| {})),
        ("a decreasing time", with(&|o| o.time = -1.0)),
        ("a time of NaN", with(&|o| o.time = f64::NAN)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_planner_may_give_up_but_not_run_away() {
        let of = |code| judge(&[("zeros", None), ("NaN", Some(code))]).verdict;
        assert_eq!(judge(&[("NaN", None)]).verdict, Verdict::Pass);
        assert_eq!(of(FaultCode::Error), Verdict::Pass);
        assert_eq!(of(FaultCode::InvalidOutput), Verdict::Warn);
        for lost in [FaultCode::OutOfFuel, FaultCode::Hung, FaultCode::Crashed, FaultCode::OutOfMemory] {
            assert_eq!(of(lost), Verdict::Fail);
        }
    }

    #[test]
    fn what_ran_away_is_named_with_its_code() {
        let seen = [("NaN", Some(FaultCode::Panic)), ("no wheels", Some(FaultCode::OutOfFuel))];
        assert_eq!(judge(&seen).detail, "planner/out-of-fuel after no wheels");
    }

    #[test]
    fn every_extreme_differs_from_the_others() {
        let all = extremes(&Observation { wheels: vec![Wheel::default(); 4], ..Observation::default() });
        let texts: std::collections::BTreeSet<String> = all.iter().map(|(_, o)| format!("{o:?}")).collect();
        // Zeros and a standing time are the same for a vehicle that stands at the origin.
        assert_eq!(texts.len(), all.len() - 1);
    }
}
