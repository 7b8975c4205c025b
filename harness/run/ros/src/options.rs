//! Options of a planner that is a ROS 2 node.

use std::collections::BTreeMap;
use std::net::{IpAddr, Ipv4Addr, UdpSocket};
use std::time::Duration;

use vb_rosmsg::convert::Datum;
use vb_sdk::metadata::{Metadata, Need, Sensor};

/// The last domain whose ports exist: 7400 + 250 · 232 + 11 is below 65536 (RTPS 2.5, 9.6.2).
pub const LAST_DOMAIN: u16 = 232;

/// The clock mode: lockstep or real time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pace {
    /// Simulated time advances only after the answer to the last tick.
    Lockstep,
    /// Simulated time advances with the wall clock; commands count that come within the deadline after their tick.
    RealTime {
        /// The deadline, s of wall-clock time: positive, and at most the control period.
        deadline: f64,
    },
}

/// Options of a planner that is a ROS 2 node.
#[derive(Clone, Debug)]
pub struct Options {
    /// The name of the planner in results.
    pub name: String,
    /// The version of the planner in results.
    pub version: String,
    /// The DDS domain (`ROS_DOMAIN_ID`), 0 to [`LAST_DOMAIN`].
    pub domain: u16,
    /// The addresses of the network interfaces to use; none for loopback alone.
    pub interfaces: Vec<IpAddr>,
    /// The time between two ticks, s: a multiple of 1 ms.
    pub control_period: f64,
    /// The sensors whose topics are published.
    pub needs: Vec<Need>,
    /// The clock mode: lockstep or real time.
    pub pace: Pace,
    /// The wall-clock time for which a task waits for a node that publishes commands.
    pub start_timeout: Duration,
    /// The wall-clock time for which a tick waits for its answer in lockstep.
    pub answer_timeout: Duration,
    /// The place of the world's origin on the Earth, for `/gps/fix`.
    pub datum: Datum,
    /// The place of each task in its suite, from which its clock starts. It makes the clock of a run advance from task to task without
    /// making one task depend on another.
    pub places: BTreeMap<String, usize>,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            name: "ros".to_owned(),
            version: "1".to_owned(),
            domain: 0,
            interfaces: Vec::new(),
            control_period: 0.1,
            needs: Need::DEFAULT.to_vec(),
            pace: Pace::Lockstep,
            start_timeout: Duration::from_secs(60),
            answer_timeout: Duration::from_secs(60),
            datum: Datum::default(),
            places: BTreeMap::new(),
        }
    }
}

/// The option that is wrong, and why.
#[derive(Debug, thiserror::Error)]
pub enum OptionsError {
    /// The domain has no ports.
    #[error("domain {0}: must lie in 0 to {LAST_DOMAIN}")]
    Domain(u16),
    /// The name or the version can't stand in results.
    #[error(
        "the name or version {0:?} of the planner is not 1 to 60 letters, digits, dots, dashes and underscores"
    )]
    Name(String),
    /// No interface has the address.
    #[error("interface {address}: no network interface of this machine has this address ({source})")]
    Interface {
        address: IpAddr,
        /// The message of the operating system.
        source: std::io::Error,
    },
    /// The deadline of the real-time mode.
    #[error("deadline {deadline} s: it must be positive and at most the control period of {period} s")]
    Deadline {
        /// The deadline, s.
        deadline: f64,
        /// The control period, s.
        period: f64,
    },
    /// Velocities can't be controlled.
    #[error("sensors {0}: velocity commands need pose or wheel-odometry for the speed")]
    Speed(String),
    /// The place on the Earth.
    #[error("datum {latitude},{longitude},{altitude}: want degrees within ±90 and ±180, and metres within ±10000", latitude = .0.latitude, longitude = .0.longitude, altitude = .0.altitude)]
    Datum(Datum),
}

impl Options {
    /// Checks all options.
    ///
    /// # Errors
    /// Returns the first that is wrong.
    pub fn check(&self) -> Result<(), OptionsError> {
        if self.domain > LAST_DOMAIN {
            return Err(OptionsError::Domain(self.domain));
        }
        for name in [&self.name, &self.version] {
            let good = name.bytes().all(|b| b.is_ascii_alphanumeric() || b"._-".contains(&b));
            if !good || !(1..=60).contains(&name.len()) {
                return Err(OptionsError::Name(name.clone()));
            }
        }
        for &address in &self.interfaces {
            UdpSocket::bind((address, 0)).map_err(|source| OptionsError::Interface { address, source })?;
        }
        if let Pace::RealTime { deadline } = self.pace
            && !(deadline > 0.0 && deadline <= self.control_period)
        {
            return Err(OptionsError::Deadline { deadline, period: self.control_period });
        }
        if !self.has(Sensor::Pose) && !self.has(Sensor::WheelOdometry) {
            let needs: Vec<String> = self.needs.iter().map(ToString::to_string).collect();
            return Err(OptionsError::Speed(needs.join(", ")));
        }
        if !self.datum.is_valid() {
            return Err(OptionsError::Datum(self.datum));
        }
        Ok(())
    }

    /// Whether a sensor is declared.
    #[must_use]
    pub fn has(&self, sensor: Sensor) -> bool {
        self.needs.iter().any(|need| need.sensor == sensor)
    }

    /// The addresses of the interfaces to use.
    #[must_use]
    pub fn addresses(&self) -> Vec<IpAddr> {
        if self.interfaces.is_empty() {
            vec![IpAddr::V4(Ipv4Addr::LOCALHOST)]
        } else {
            self.interfaces.clone()
        }
    }

    /// The metadata of the planner, in the form of a plugin's.
    pub(crate) fn metadata(&self) -> Metadata {
        Metadata {
            abi: vb_host::AbiVersion::NEWEST.name().to_owned(),
            name: self.name.clone(),
            version: self.version.clone(),
            authors: Vec::new(),
            about: "A ROS 2 node".to_owned(),
            control_period: self.control_period,
            params: Vec::new(),
            needs: self.needs.clone(),
            needs_without_maps: Vec::new(),
            models: Vec::new(),
        }
    }

    /// The hash by which results know the planner: of what the user says of it, since nothing else of it is known.
    pub(crate) fn identity(&self) -> String {
        let needs: Vec<String> = self.needs.iter().map(ToString::to_string).collect();
        let said = format!(
            "ros\n{}\n{}\n{}\n{:?}\n{}\n",
            self.name,
            self.version,
            self.control_period,
            self.pace,
            needs.join("\n")
        );
        vb_files::sha256(said.as_bytes())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_option_is_checked_and_named() {
        Options::default().check().unwrap();
        let said = |change: fn(&mut Options)| {
            let mut options = Options::default();
            change(&mut options);
            options.check().unwrap_err().to_string()
        };
        assert_eq!(said(|o| o.domain = 233), "domain 233: must lie in 0 to 232");
        assert!(said(|o| o.name = "a b".into()).contains("\"a b\""));
        assert!(said(|o| o.version.clear()).contains("\"\""));
        // Documentation addresses (RFC 5737) are no machine's own.
        let told = said(|o| o.interfaces = vec![IpAddr::from([192, 0, 2, 1])]);
        assert!(told.starts_with("interface 192.0.2.1: no network interface"), "{told}");
        assert!(said(|o| o.pace = Pace::RealTime { deadline: 0.2 }).starts_with("deadline 0.2 s"));
        assert!(said(|o| o.pace = Pace::RealTime { deadline: f64::NAN }).starts_with("deadline NaN s"));
        let told = said(|o| o.needs = vec![Need::parse("imu").unwrap()]);
        assert!(told.starts_with("sensors imu: "), "{told}");
        assert!(said(|o| o.datum.latitude = 91.0).starts_with("datum 91,0,0: "));
    }

    #[test]
    fn the_identity_depends_on_what_the_user_says_of_the_planner() {
        let of = |change: fn(&mut Options)| {
            let mut options = Options::default();
            change(&mut options);
            options.identity()
        };
        let all = [
            of(|_| {}),
            of(|o| o.name = "nav2".into()),
            of(|o| o.version = "2".into()),
            of(|o| o.control_period = 0.05),
            of(|o| o.pace = Pace::RealTime { deadline: 0.1 }),
            of(|o| o.needs.truncate(1)),
        ];
        assert!(all.iter().enumerate().all(|(k, hash)| !all[..k].contains(hash)));
        // How it is reached is not what it is.
        assert_eq!(of(|o| o.domain = 7), all[0]);
    }
}
