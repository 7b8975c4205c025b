//! `vb-harness ros`.

use std::path::Path;
use std::time::Duration;

use vb_host::Limits;
use vb_ros::{Options, Pace};
use vb_rosmsg::convert::Datum;
use vb_sdk::metadata::Need;
use vb_world::WorldInfo;

use crate::args::{RosArgs, RunArgs};
use crate::error::CliError;
use crate::{output, run, suite};

/// The variable by which nodes of ROS 2 choose their domain.
const DOMAIN_VAR: &str = "ROS_DOMAIN_ID";
/// In place of a planner's file in records.
const PATH: &str = "ros";

pub(crate) fn ros(args: &RosArgs) -> Result<(), CliError> {
    let options = options(args)?;
    let interfaces: Vec<String> = options.addresses().iter().map(ToString::to_string).collect();
    let place = format!("in DDS domain {} on {}", options.domain, interfaces.join(", "));
    let is_real_time = matches!(options.pace, Pace::RealTime { .. });
    let plugin = vb_ros::plugin(options, &Limits::default()).map_err(CliError::usage)?;
    output::say("note: a ROS 2 node is not sandboxed, and its results are not eligible for ranking");
    if is_real_time {
        output::say("note: in real time, results depend on the speed of the machine; records are marked");
    }
    output::note(&format!(
        "waiting for a node that publishes /cmd_vel or /ackermann_cmd, or calls /vertibench/step, {place}"
    ));
    let mut wanted = RunArgs::new(Path::new(PATH));
    // Topics have no task: nodes can't distinguish two tasks that run at the same time.
    wanted.jobs.jobs = Some(1);
    (wanted.drive, wanted.format) = (args.drive.clone(), args.format);
    run::drive_and_tell(&wanted, Some(plugin))
}

fn options(args: &RosArgs) -> Result<Options, CliError> {
    let worlds = suite::open(&args.drive.suite)?;
    let places = worlds.worlds().iter().flat_map(WorldInfo::task_ids).enumerate();
    let mut needs: Vec<Need> = Vec::new();
    for need in &args.sensors {
        Need::add(&mut needs, &need.to_string()).map_err(|e| CliError::usage(format!("--sensor: {e}")))?;
    }
    if needs.is_empty() {
        needs = Need::DEFAULT.to_vec();
    }
    let [latitude, longitude, altitude] = args.datum;
    let wait = |seconds: f64| Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX);
    Ok(Options {
        name: args.name.clone(),
        version: args.planner_version.clone(),
        domain: args.domain.map_or_else(domain, Ok)?,
        interfaces: args.interfaces.clone(),
        control_period: args.period,
        needs,
        pace: if args.real_time {
            Pace::RealTime { deadline: args.deadline.unwrap_or(args.period) }
        } else {
            Pace::Lockstep
        },
        start_timeout: wait(args.start_timeout).min(LONGEST),
        answer_timeout: wait(args.answer_timeout).min(LONGEST),
        datum: Datum { latitude, longitude, altitude },
        places: places.map(|(place, id)| (id.to_string(), place)).collect(),
    })
}

/// Maximum waiting time: the clock has no later times.
const LONGEST: Duration = Duration::from_secs(365 * 24 * 3600);

/// The domain that the environment says; 0 if it says none.
fn domain() -> Result<u16, CliError> {
    match std::env::var_os(DOMAIN_VAR).filter(|value| !value.is_empty()) {
        None => Ok(0),
        Some(value) => value.to_str().and_then(|text| text.trim().parse().ok()).ok_or_else(|| {
            CliError::usage(format!("{DOMAIN_VAR} is {}: want a number from 0 to 232", value.display()))
        }),
    }
}
