//! `vb-harness ros`.

use std::net::IpAddr;
use std::path::Path;
use std::time::Duration;

use clap::Args;
use vb_host::Limits;
use vb_ros::{LAST_DOMAIN, Options, Pace};
use vb_rosmsg::convert::Datum;
use vb_sdk::metadata::Need;
use vb_world::WorldInfo;

use crate::args::FormatArgs;
use crate::args::values::duration;
use crate::command::run::{self, DriveArgs, RunArgs};
use crate::command::suite;
use crate::error::CliError;
use crate::output;

#[derive(Debug, Args)]
pub(crate) struct RosArgs {
    /// Name of the node in results
    #[arg(long, value_name = "NAME", default_value = "ros")]
    pub(crate) name: String,
    /// Version of the node in results
    #[arg(long, value_name = "VERSION", default_value = "1")]
    pub(crate) planner_version: String,
    /// DDS domain, 0 to 232; default: the variable ROS_DOMAIN_ID, or 0
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(..=i64::from(LAST_DOMAIN)))]
    pub(crate) domain: Option<u16>,
    /// IP address of a network interface; may be repeated; default: loopback, which only this machine can reach
    #[arg(long = "interface", value_name = "ADDRESS")]
    pub(crate) interfaces: Vec<IpAddr>,
    /// Sensor whose topics are published, e.g. imu or "lidar 5" (Hz); may be repeated; default: pose and wheel-odometry
    #[arg(long = "sensor", value_name = "SENSOR", value_parser = Need::parse)]
    pub(crate) sensors: Vec<Need>,
    /// Simulated time between two ticks of /clock, s or with a unit, e.g. 50ms; a multiple of 1 ms
    #[arg(long, value_name = "TIME", default_value = "0.1", value_parser = duration)]
    pub(crate) period: f64,
    /// Let simulated time pass with the wall clock instead of waiting for answers; records are marked
    #[arg(long)]
    pub(crate) real_time: bool,
    /// With --real-time: wall-clock time within which a tick must be answered; default: --period
    #[arg(long, value_name = "TIME", requires = "real_time", value_parser = duration)]
    pub(crate) deadline: Option<f64>,
    /// Wall-clock time for which a task waits for a node that publishes commands
    #[arg(long, value_name = "TIME", default_value = "60s", value_parser = duration)]
    pub(crate) start_timeout: f64,
    /// Wall-clock time for which a tick waits for its answer
    #[arg(long, value_name = "TIME", default_value = "60s", value_parser = duration, conflicts_with = "real_time")]
    pub(crate) answer_timeout: f64,
    /// Place of the world's origin on the Earth for /gps/fix: latitude and longitude, degrees, and altitude, m
    #[arg(long, value_name = "LAT,LON,ALT", default_value = "0,0,0", value_parser = datum, allow_hyphen_values = true)]
    pub(crate) datum: [f64; 3],
    #[command(flatten)]
    pub(crate) drive: DriveArgs,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

/// Three numbers.
fn datum(text: &str) -> Result<[f64; 3], String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    let wanted = || "want latitude, longitude and altitude, e.g. 38.83,-77.31,120".to_owned();
    numbers.ok().and_then(|numbers| numbers.try_into().ok()).ok_or_else(wanted)
}

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
