//! `vb-harness ros`.

use std::net::IpAddr;

use clap::Args;
use vb_ros::LAST_DOMAIN;
use vb_sdk::metadata::Need;

use super::FormatArgs;
use super::run::DriveArgs;
use super::values::duration;

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
