//! `vb-harness vehicle`.

use std::path::PathBuf;

use clap::{ArgGroup, Args, Subcommand};

use super::exit_codes::codes;
use super::values::{duration, key_value, scale};
use super::{ForceArgs, FormatArgs, JobsArgs, TIME_STEP};
use crate::error::CHECKS_FAILED;

#[derive(Debug, Subcommand)]
pub(crate) enum VehicleCommand {
    /// Show a vehicle's data, and draw it
    Show(VehicleShowArgs),
    /// Validate all values of a vehicle file
    Validate(VehicleArgs),
    /// Drive a vehicle through standard events, and compare it with theory, published figures and Project Chrono
    #[command(
        after_help = codes(&[CHECKS_FAILED]),
        mut_arg("jobs", |arg| arg.help("Number of events that are driven in parallel; default: number of cores"))
    )]
    Test(VehicleTestArgs),
    /// Replay recorded wheel speeds of a skid-steered vehicle, and compare its motion with the recording
    Compare(VehicleCompareArgs),
    /// Convert a bag of ROS 2 (odometry, wheel speeds or velocity commands) into a recording for vehicle compare
    Bag(VehicleBagArgs),
    /// Convert a vehicle of another program (JSON set of Project Chrono, URDF, xacro) into a vehicle file
    Import(VehicleImportArgs),
}

#[derive(Debug, Args)]
pub(crate) struct VehicleImportArgs {
    /// File of the vehicle: Chrono's JSON with "Type": "Vehicle", URDF or xacro
    #[arg(value_name = "FILE")]
    pub(crate) file: PathBuf,
    /// Vehicle file to write
    #[arg(short, long, value_name = "FILE")]
    pub(crate) out: PathBuf,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    /// Name of the vehicle; default: the name in FILE
    #[arg(long, value_name = "NAME")]
    pub(crate) name: Option<String>,
    /// Scale of the worlds that the vehicle is made for; default: chosen from its length
    #[arg(long, value_name = "FACTOR", value_parser = scale)]
    pub(crate) scale: Option<f64>,
    /// Directory to which paths in FILE are relative; default: searched above FILE
    #[arg(long, value_name = "DIR")]
    pub(crate) data: Option<PathBuf>,
    /// Chrono: file of the engine; default: the one that the vehicle names, else chosen from the set
    #[arg(long, value_name = "FILE")]
    pub(crate) engine: Option<PathBuf>,
    /// Chrono: file of the transmission; default: chosen from the set
    #[arg(long, value_name = "FILE")]
    pub(crate) transmission: Option<PathBuf>,
    /// Chrono: file of the tyre; once for all axles, or once per axle in the order of the file; default: chosen from the set
    #[arg(long = "tyre", value_name = "FILE")]
    pub(crate) tyres: Vec<PathBuf>,
    /// xacro: value of an argument; may be repeated
    #[arg(long = "arg", value_name = "NAME=VALUE", value_parser = key_value)]
    pub(crate) arguments: Vec<(String, String)>,
}

#[derive(Debug, Args)]
pub(crate) struct VehicleArgs {
    /// Vehicle: a name or a file
    #[arg(value_name = "NAME|FILE")]
    pub(crate) vehicle: String,
}

#[derive(Debug, Args)]
pub(crate) struct VehicleShowArgs {
    /// Vehicle: a name or a file
    #[arg(value_name = "NAME|FILE")]
    pub(crate) vehicle: String,
    /// File for a drawing of side and top view (SVG)
    #[arg(long, value_name = "FILE")]
    pub(crate) svg: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Debug, Args)]
pub(crate) struct VehicleCompareArgs {
    /// Vehicle: a name or a file
    #[arg(value_name = "NAME|FILE")]
    pub(crate) vehicle: String,
    /// Recording: CSV with the columns window, time (s), left and right (wheel speeds of a side, rad/s), x, y (m) and yaw (rad); rows of a
    /// window follow each other, and its first and last row have a pose. Or a table of DRIVE (torch_ready_dataframe.csv), with a window in
    /// each row
    #[arg(value_name = "RECORDING")]
    pub(crate) recording: PathBuf,
    /// Friction coefficients of the ground, which recordings do not have
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_value = "0.2,0.3,0.4,0.5,0.6,0.8,1")]
    pub(crate) friction: Vec<f64>,
    /// Directory for report.html, results.json and the table of windows; default: runs/compare-VEHICLE-N
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    /// Simulation step, s or with a unit (0.01ms to 10ms)
    #[arg(long, value_name = "TIME", default_value_t = TIME_STEP, value_parser = duration)]
    pub(crate) time_step: f64,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

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

#[derive(Debug, Args)]
#[command(group(ArgGroup::new("what").required(true)))]
pub(crate) struct VehicleTestArgs {
    /// Vehicle: a name or a file
    #[arg(value_name = "NAME|FILE", group = "what")]
    pub(crate) vehicle: Option<String>,
    /// Directory for report.html, results.json and the time series; default: runs/test-VEHICLE-N
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    /// Tyre to fit, by its name in the vehicle file, e.g. rigid; drives in a reference's set-up don't depend on it
    #[arg(long, value_name = "NAME")]
    pub(crate) tyre: Option<String>,
    /// Event to run; may be repeated; default: all
    #[arg(long = "event", value_name = "NAME")]
    pub(crate) events: Vec<String>,
    /// OpenCRG file that the events ride-course and half-round drive instead of their courses; without --event, only these run
    #[arg(long, value_name = "FILE")]
    pub(crate) course: Option<PathBuf>,
    /// List the events and exit
    #[arg(long, group = "what")]
    pub(crate) list: bool,
    /// Reference figures in addition to theory; default: tasks/validation/VEHICLE.yaml, if it exists
    #[arg(long, value_name = "FILE")]
    pub(crate) references: Option<PathBuf>,
    /// Simulation step, s or with a unit (0.01ms to 10ms)
    #[arg(long, value_name = "TIME", default_value_t = TIME_STEP, value_parser = duration)]
    pub(crate) time_step: f64,
    #[command(flatten)]
    pub(crate) jobs: JobsArgs,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}
