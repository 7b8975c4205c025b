//! `vb-harness vehicle bag`.

use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;
use vb_bag::{Selection, Wheels};

use crate::args::values::duration;
use crate::args::{ForceArgs, FormatArgs};
use crate::error::CliError;
use crate::{output, places};

#[derive(Debug, Args)]
pub(crate) struct VehicleBagArgs {
    /// Vehicle: a name or a file
    #[arg(value_name = "NAME|FILE")]
    pub(crate) vehicle: String,
    /// Bag of ROS 2: an MCAP file, or the folder of a bag with MCAP files
    #[arg(value_name = "BAG")]
    pub(crate) bag: PathBuf,
    /// CSV file to write
    #[arg(short, long, value_name = "FILE")]
    pub(crate) out: PathBuf,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    /// Topic of the poses (nav_msgs/msg/Odometry); default: the only one
    #[arg(long, value_name = "TOPIC")]
    pub(crate) odometry: Option<String>,
    /// Topic of the wheel speeds (sensor_msgs/msg/JointState; joints with left and right in their names) or of the velocity commands
    /// (geometry_msgs/msg/Twist or TwistStamped); default: the only one with wheel speeds, else the only one with commands
    #[arg(long, value_name = "TOPIC")]
    pub(crate) speeds: Option<String>,
    /// Topic of an inertial sensor (sensor_msgs/msg/Imu, z axis up), whose yaw rate gives the heading within a window; default: the heading
    /// of the odometry
    #[arg(long, value_name = "TOPIC")]
    pub(crate) imu: Option<String>,
    /// Duration of a window, s or with a unit (0.2s to 10min)
    #[arg(long, value_name = "TIME", default_value = "2s", value_parser = duration)]
    pub(crate) window: f64,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Serialize)]
struct RecordingMessage<'a> {
    event: &'static str,
    vehicle: &'a str,
    bag: &'a Path,
    recording: &'a Path,
    odometry: &'a str,
    speeds: &'a str,
    commanded: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    imu: Option<&'a str>,
    windows: usize,
    gaps: usize,
    /// s.
    duration: f64,
}

pub(super) fn convert(args: &VehicleBagArgs) -> Result<(), CliError> {
    let (_, spec) = places::vehicle(&args.vehicle)?;
    if spec.skid.is_none() {
        return Err(CliError::usage(format!(
            "{}: has no skid steering; vehicle compare replays recordings of skid-steered vehicles, e.g. husky",
            spec.name
        )));
    }
    output::must_not_replace(&args.out, args.force)?;
    let bench =
        vb_validate::Bench::new(&spec, &[], vb_sim::SimOptions::default().step).map_err(CliError::input)?;
    let [radius, track] = bench.radius_and_track();
    let bag = vb_bag::read(&args.bag).map_err(CliError::input)?;
    let selection = Selection {
        odometry: args.odometry.clone(),
        speeds: args.speeds.clone(),
        imu: args.imu.clone(),
        window: args.window,
    };
    let drive = bag
        .drive(&selection, Wheels { radius, track })
        .map_err(|e| CliError::input(format!("{}: {e}", args.bag.display())))?;
    for (topic, count) in bag.skipped() {
        output::say(&format!(
            "warning: {topic}: {count} messages skipped: a number is not finite, or an orientation is not a unit quaternion"
        ));
    }
    output::write(&args.out, drive.csv())?;
    if args.format.is_json() {
        output::json(&RecordingMessage {
            event: "recording",
            vehicle: &spec.name,
            bag: &args.bag,
            recording: &args.out,
            odometry: &drive.odometry,
            speeds: &drive.speeds,
            commanded: drive.is_commanded,
            imu: drive.imu.as_deref(),
            windows: drive.windows(),
            gaps: drive.gaps,
            duration: drive.duration,
        });
        return Ok(());
    }
    let speeds = if drive.is_commanded {
        format!(
            "wheel speeds from commands on {} (radius {radius:.4} m, track {track:.3} m, no slip)",
            drive.speeds
        )
    } else {
        format!("wheel speeds from {}", drive.speeds)
    };
    let heading = drive.imu.as_ref().map_or_else(String::new, |imu| format!(", headings from {imu}"));
    output::text(&format!(
        "{}: {} windows of {} s in {:.1} s with {} gaps; poses from {}{heading}; {speeds}\n",
        args.out.display(),
        drive.windows(),
        args.window,
        drive.duration,
        drive.gaps,
        drive.odometry,
    ));
    output::say(&format!("next: vb-harness vehicle compare {} {}", args.vehicle, output::word(&args.out)));
    Ok(())
}
