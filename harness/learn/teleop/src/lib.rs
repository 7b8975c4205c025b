//! A person drives: a page in the browser, and the simulation behind it in real time.
//!
//! [`Server`] listens on this machine alone, at an address with a random token, and serves the page and its connection.
//! [`Wheel`] is what the person does; [`PersonDriver`] brings it into a trial, and [`Live`] shows the trial to the page.

mod driver;
mod server;
mod wheel;

pub use driver::{CONTROL_PERIOD, Live, PersonDriver};
pub use server::{Ask, Motion, Server, TeleopError};
pub use wheel::Wheel;
