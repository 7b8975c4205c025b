//! A recorded task to look at: as a page in three dimensions that needs nothing else, and as an MCAP file.
//!
//! A trace holds samples of the vehicle, ten a second as a rule, and the commands that it was given. Simulations repeat
//! bit for bit, so [`Motion`] drives the task again by those commands and takes whatever is to be seen from the simulation:
//! fifty poses a second, each wheel, the ruts. The state hash of the record proves that it is the same drive. Where it can't be
//! repeated – commands between samples are unknown, or the harness is another – the samples themselves are shown.

mod attitude;
mod debug;
mod error;
mod facts;
pub mod film;
mod foxglove_file;
mod grains;
mod linkage;
mod messages;
mod motion;
mod packed;
mod page;
mod ros_file;
mod scene;
mod sensed;
mod sensors_file;

pub use attitude::attitude;
pub use debug::PlannerSeries;
pub use error::ReplayError;
pub use foxglove_file::{RUN_COLOURS, write_mcap};
pub use grains::{GrainMove, Grains};
pub use motion::{Motion, Repeat, Rut, Setting, WheelContact, WheelFrame};
pub use page::{Link, Links, SCRIPT_FILE, live_page, page, script};
pub use ros_file::write_ros2_mcap;
pub use scene::{Replay, ReplayRun, live_scene};
pub use sensed::{Sensed, Sensors};
