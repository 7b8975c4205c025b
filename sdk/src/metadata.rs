//! What a plugin says about itself, readable without running it.
//!
//! [`export_planner!`](crate::export_planner) puts a text into a section of the file: the custom section
//! [`WASM_SECTION`] of the core WASM module, or the section [`ELF_SECTION`] of a native library. It is UTF-8, one
//! `key: value` a line, with `\\`, `\n` and `\r` escaped by a backslash. `param` begins a parameter, to which the
//! `default` and `help` that follow belong. `need` names a sensor and may say how often it is to be read, in Hz: `need: lidar
//! 10`; a planner without a need gets [`Need::DEFAULT`]. `need-without-maps` does the same for sensors that it needs only where
//! the perception profile leaves out one of the task's maps. `model` names learned weights that the planner has, with their hash and
//! those of what they were learned from. Unknown keys are ignored, so later versions may add some.

use std::fmt;

/// The name of the custom section of a WASM plugin.
pub const WASM_SECTION: &str = "vb:planner";
/// The name of the section of a native plugin in ELF.
pub const ELF_SECTION: &str = ".vb.planner";
/// The name of the section of a native plugin in Mach-O.
pub const MACHO_SECTION: &str = "__vb_planner";

/// What a plugin says about itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Metadata {
    /// The version of the planner interface, e.g. `0.1`.
    pub abi: String,
    /// The name of the planner.
    pub name: String,
    /// The version of the planner's package.
    pub version: String,
    /// The authors of the planner's package.
    pub authors: Vec<String>,
    /// One sentence on what the planner does.
    pub about: String,
    /// The wanted time between two steps, s: a multiple of 1 ms.
    pub control_period: f64,
    /// The parameters that a user may set.
    pub params: Vec<ParamSpec>,
    /// The sensors that the planner asks for, as it declares them. It is empty for planners that want the default, as
    /// [`Metadata::sensors`] gives it.
    pub needs: Vec<Need>,
    /// The sensors that it asks for in addition where the perception profile leaves out one of the task's maps.
    pub needs_without_maps: Vec<Need>,
    /// The learned weights that the planner has, each with its hash and those of what it was learned from.
    pub models: Vec<String>,
}

macro_rules! sensors {
    ($($(#[$doc:meta])* $variant:ident = $name:literal;)*) => {
        /// A sensor that a planner may ask for. What it measures is described with the field of
        /// [`Observation`](crate::Observation) of its name.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Sensor {
            $($(#[$doc])* $variant,)*
        }

        impl Sensor {
            /// All sensors.
            pub const ALL: &[Self] = &[$(Self::$variant,)*];

            /// The name of the sensor in metadata, messages and profiles.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)*
                }
            }
        }
    };
}

sensors! {
    /// The estimate of position, attitude and velocities.
    Pose = "pose";
    /// The inertial measurement unit.
    Imu = "imu";
    /// The spins and travels of the wheels.
    WheelOdometry = "wheel-odometry";
    /// The position from satellites.
    Gnss = "gnss";
    /// The spinning lidar.
    Lidar = "lidar";
    /// The depth camera.
    Depth = "depth";
    /// The map of the surroundings, built from lidar and depth camera.
    LocalMap = "local-map";
}

impl Sensor {
    /// The sensor of this name; `None` if there is none.
    #[must_use]
    pub fn find(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|sensor| sensor.name() == name)
    }
}

/// A sensor that a planner asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Need {
    /// The sensor.
    pub sensor: Sensor,
    /// How often it is to be read, Hz; `None` for as often as the profile says, or at every step of the planner for pose
    /// and wheels.
    pub rate: Option<f64>,
}

impl Need {
    /// What a planner gets that declares no need.
    pub const DEFAULT: &[Self] =
        &[Self { sensor: Sensor::Pose, rate: None }, Self { sensor: Sensor::WheelOdometry, rate: None }];

    /// Adds a need to a list, in which each sensor is once.
    ///
    /// # Errors
    /// Returns a text that says what is wrong: as [`Need::parse`] does, or that the sensor is there already.
    pub fn add(list: &mut Vec<Self>, text: &str) -> Result<(), String> {
        let need = Self::parse(text)?;
        if list.iter().any(|n| n.sensor == need.sensor) {
            return Err(format!("{} is asked for twice", need.sensor.name()));
        }
        list.push(need);
        Ok(())
    }

    /// Reads `lidar` or `lidar 10`. Underscores may stand for hyphens, since names in Rust have none.
    ///
    /// # Errors
    /// Returns a text that says what is wrong and what there is.
    pub fn parse(text: &str) -> Result<Self, String> {
        let (name, rate) = text.split_once(' ').map_or((text, None), |(name, rate)| (name, Some(rate)));
        let sensor = Sensor::find(&name.replace('_', "-")).ok_or_else(|| {
            let known: Vec<&str> = Sensor::ALL.iter().map(|s| s.name()).collect();
            format!("there is no sensor `{name}`; there are {}", known.join(", "))
        })?;
        let rate = match rate.map(str::trim) {
            None => None,
            Some(text) => match text.parse() {
                Ok(rate) if is_rate(rate) => Some(rate),
                _ => {
                    return Err(format!(
                        "{name} can't be read {text} times a second; want a rate that divides 100, e.g. 100, 20, 10 or 5"
                    ));
                }
            },
        };
        Ok(Self { sensor, rate })
    }
}

impl fmt::Display for Need {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.rate {
            Some(rate) => write!(f, "{} {rate}", self.sensor.name()),
            None => f.write_str(self.sensor.name()),
        }
    }
}

/// Tells whether a sensor can be read at this rate, Hz: the period must be a multiple of the 10 ms between the samples of a
/// trial.
#[must_use]
pub fn is_rate(rate: f64) -> bool {
    let samples = 100.0 / rate;
    let nearest = samples.round();
    (1.0..1e6).contains(&nearest) && (samples - nearest).abs() < 1e-6
}

/// A parameter that a planner declares.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ParamSpec {
    /// The name of the parameter.
    pub key: String,
    /// The value that holds when the user sets none.
    pub default: String,
    /// What the parameter means, with its unit.
    pub help: String,
}

/// The reason why a metadata text can't be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MetadataError {
    /// The text is not UTF-8.
    NotUtf8,
    /// A line is not `key: value`, or its value doesn't fit its key.
    BadLine {
        /// The number of the line, counted from 1.
        line: usize,
        /// The line as it stands in the text.
        text: String,
    },
    /// The planner asks for a sensor that there isn't, or too often, or twice.
    BadNeed {
        /// The number of the line, counted from 1.
        line: usize,
        /// What is wrong.
        reason: String,
    },
    /// A key that must be there is missing.
    Missing {
        /// The name of the missing key.
        key: &'static str,
    },
}

impl fmt::Display for MetadataError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotUtf8 => write!(f, "it is not UTF-8"),
            Self::BadLine { line, text } => write!(f, "line {line} is `{text}`"),
            Self::BadNeed { line, reason } => write!(f, "line {line} asks for a sensor: {reason}"),
            Self::Missing { key } => write!(f, "`{key}` is missing"),
        }
    }
}

impl std::error::Error for MetadataError {}

impl Metadata {
    /// The text of the section, which [`parse`](Self::parse) reads. The authors' names must not hold a colon.
    #[must_use]
    pub fn to_text(&self) -> String {
        let mut text = String::new();
        let mut line = |key: &str, value: &str| {
            let value = value.replace('\\', "\\\\").replace('\n', "\\n").replace('\r', "\\r");
            text.extend([key, ": ", &value, "\n"]);
        };
        line("abi", &self.abi);
        line("name", &self.name);
        line("version", &self.version);
        line("authors", &self.authors.join(":"));
        line("about", &self.about);
        line("control-period", &self.control_period.to_string());
        for param in &self.params {
            line("param", &param.key);
            line("default", &param.default);
            line("help", &param.help);
        }
        for need in &self.needs {
            line("need", &need.to_string());
        }
        for need in &self.needs_without_maps {
            line("need-without-maps", &need.to_string());
        }
        for model in &self.models {
            line("model", model);
        }
        text
    }

    /// The sensors that the planner gets: those that it needs, or [`Need::DEFAULT`], and those that it needs without maps if
    /// the perception profile doesn't give all maps.
    #[must_use]
    pub fn sensors(&self, all_maps: bool) -> Vec<Need> {
        let mut needs = if self.needs.is_empty() { Need::DEFAULT.to_vec() } else { self.needs.clone() };
        if !all_maps {
            for more in &self.needs_without_maps {
                if !needs.iter().any(|n| n.sensor == more.sensor) {
                    needs.push(*more);
                }
            }
        }
        needs
    }

    /// Reads the text of the section.
    ///
    /// # Errors
    /// Returns an error if the text is not the one that [the module](self) describes.
    pub fn parse(bytes: &[u8]) -> Result<Self, MetadataError> {
        let text = std::str::from_utf8(bytes).map_err(|_| MetadataError::NotUtf8)?;
        let (mut abi, mut name, mut version, mut period) = (None, None, None, None);
        let (mut authors, mut about, mut params) = (Vec::new(), String::new(), Vec::<ParamSpec>::new());
        let (mut needs, mut without_maps) = (Vec::<Need>::new(), Vec::<Need>::new());
        let mut models = Vec::new();
        for (number, line) in text.lines().enumerate() {
            let bad = || MetadataError::BadLine { line: number + 1, text: line.to_owned() };
            let (key, value) = line.split_once(": ").ok_or_else(bad)?;
            let value = unescape(value).ok_or_else(bad)?;
            match key {
                "abi" => abi = Some(value),
                "name" => name = Some(Some(value).filter(|name| is_name(name)).ok_or_else(bad)?),
                "version" => version = Some(value),
                // Cargo joins the authors of a package by colons.
                "authors" => {
                    authors = value.split(':').filter(|a| !a.is_empty()).map(str::to_owned).collect()
                }
                "about" => about = value,
                "control-period" => {
                    let seconds = value.parse().ok().filter(|s| is_control_period(*s)).ok_or_else(bad)?;
                    period = Some(seconds);
                }
                "param" => params.push(ParamSpec { key: value, default: String::new(), help: String::new() }),
                "default" => params.last_mut().ok_or_else(bad)?.default = value,
                "help" => params.last_mut().ok_or_else(bad)?.help = value,
                "need" | "need-without-maps" => {
                    let list = if key == "need" { &mut needs } else { &mut without_maps };
                    Need::add(list, &value)
                        .map_err(|reason| MetadataError::BadNeed { line: number + 1, reason })?;
                }
                "model" => models.push(value),
                _ => {}
            }
        }
        let missing = |key| MetadataError::Missing { key };
        Ok(Self {
            abi: abi.ok_or(missing("abi"))?,
            name: name.ok_or(missing("name"))?,
            version: version.ok_or(missing("version"))?,
            authors,
            about,
            control_period: period.ok_or(missing("control-period"))?,
            params,
            needs,
            needs_without_maps: without_maps,
            models,
        })
    }
}

fn unescape(text: &str) -> Option<String> {
    let mut out = String::with_capacity(text.len());
    let mut chars = text.chars();
    while let Some(c) = chars.next() {
        out.push(match c {
            '\\' => match chars.next()? {
                'n' => '\n',
                'r' => '\r',
                '\\' => '\\',
                _ => return None,
            },
            c => c,
        });
    }
    Some(out)
}

/// Tells whether the harness can keep this control period (s): it must be a positive multiple of its step of 1 ms.
#[must_use]
pub const fn is_control_period(seconds: f64) -> bool {
    let steps = seconds * 1000.0;
    // Decimal fractions of a second are not exact in binary; a millionth of a step is.
    let nearest = (steps + 0.5) as u64;
    let off = steps - nearest as f64;
    nearest > 0 && nearest < 1_000_000_000 && off < 1e-6 && off > -1e-6
}

/// Tells whether this can be the name of a planner: at least one of `a-z`, `0-9`, `-` and `_`, and nothing else, since
/// files are named by it.
#[must_use]
pub const fn is_name(name: &str) -> bool {
    let bytes = name.as_bytes();
    let mut i = 0;
    while i < bytes.len() {
        if !matches!(bytes[i], b'a'..=b'z' | b'0'..=b'9' | b'-' | b'_') {
            return false;
        }
        i += 1;
    }
    !bytes.is_empty()
}

/// The length of the result of [`encode`], in bytes.
#[must_use]
pub const fn encoded_len(fields: &[(&str, &str)]) -> usize {
    let (mut length, mut i) = (0, 0);
    while i < fields.len() {
        let (key, value) = (fields[i].0.as_bytes(), fields[i].1.as_bytes());
        length += key.len() + ": \n".len() + value.len();
        let mut j = 0;
        while j < value.len() {
            length += matches!(value[j], b'\n' | b'\r' | b'\\') as usize;
            j += 1;
        }
        i += 1;
    }
    length
}

/// The text of a section from its keys and values. It is evaluated at compile time, to fill a static.
#[must_use]
pub const fn encode<const N: usize>(fields: &[(&str, &str)]) -> [u8; N] {
    let mut out = [0; N];
    let (mut at, mut i) = (0, 0);
    while i < fields.len() {
        let (key, value) = (fields[i].0.as_bytes(), fields[i].1.as_bytes());
        let mut j = 0;
        while j < key.len() {
            out[at] = key[j];
            at += 1;
            j += 1;
        }
        out[at] = b':';
        out[at + 1] = b' ';
        at += 2;
        j = 0;
        while j < value.len() {
            let escaped = match value[j] {
                b'\n' => b'n',
                b'\r' => b'r',
                b'\\' => b'\\',
                _ => 0,
            };
            if escaped == 0 {
                out[at] = value[j];
            } else {
                out[at] = b'\\';
                at += 1;
                out[at] = escaped;
            }
            at += 1;
            j += 1;
        }
        out[at] = b'\n';
        at += 1;
        i += 1;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    const FIELDS: &[(&str, &str)] = &[
        ("abi", "0.1"),
        ("name", "x"),
        ("version", "1.2.3"),
        ("authors", "A B <a@b>:C"),
        ("about", "two\nlines: a\\b\r"),
        ("control-period", "0.05"),
        ("param", "speed"),
        ("default", "3.0"),
        ("help", "m/s"),
        ("param", "mode"),
        ("default", ""),
        ("later", "ignored"),
    ];
    static BYTES: [u8; encoded_len(FIELDS)] = encode(FIELDS);

    #[test]
    fn what_is_encoded_at_compile_time_reads_back() {
        let m = Metadata::parse(&BYTES).unwrap();
        assert_eq!((m.abi.as_str(), m.name.as_str(), m.version.as_str()), ("0.1", "x", "1.2.3"));
        assert_eq!(m.authors, ["A B <a@b>", "C"]);
        assert_eq!(m.about, "two\nlines: a\\b\r");
        assert_eq!(m.control_period, 0.05);
        let spec = |k: &str, d: &str, h: &str| ParamSpec { key: k.into(), default: d.into(), help: h.into() };
        assert_eq!(m.params, [spec("speed", "3.0", "m/s"), spec("mode", "", "")]);
        assert_eq!(Metadata::parse(m.to_text().as_bytes()).unwrap(), m);
    }

    #[test]
    fn a_damaged_text_is_refused_with_the_place() {
        let parse = |t: &[u8]| Metadata::parse(t).unwrap_err();
        assert_eq!(parse(b"\xff"), MetadataError::NotUtf8);
        assert_eq!(parse(b"abi: 0.1\nname"), MetadataError::BadLine { line: 2, text: "name".into() });
        assert_eq!(parse(b"default: 3"), MetadataError::BadLine { line: 1, text: "default: 3".into() });
        assert_eq!(parse(b"about: \\q"), MetadataError::BadLine { line: 1, text: "about: \\q".into() });
        assert_eq!(parse(b"abi: 0.1\nname: x\n"), MetadataError::Missing { key: "version" });
        for period in ["0", "-0.1", "nan", "inf", "0.0005", "x"] {
            let text = format!("control-period: {period}");
            assert!(matches!(parse(text.as_bytes()), MetadataError::BadLine { .. }), "{period}");
        }
    }

    #[test]
    fn models_are_read_and_written() {
        let text = "abi: 1.0\nname: x\nversion: 1\ncontrol-period: 0.1\nmodel: a.vbnn sha256 1\nmodel: b\n";
        let m = Metadata::parse(text.as_bytes()).unwrap();
        assert_eq!(m.models, ["a.vbnn sha256 1", "b"]);
        assert_eq!(Metadata::parse(m.to_text().as_bytes()).unwrap(), m);
    }

    #[test]
    fn needs_are_read_and_written() {
        let head = "abi: 1.0\nname: x\nversion: 1\ncontrol-period: 0.1\n";
        let parse = |needs: &str| Metadata::parse(format!("{head}{needs}").as_bytes());
        let m = parse("need: local_map 5\nneed: imu\n").unwrap();
        let local_map = Need { sensor: Sensor::LocalMap, rate: Some(5.0) };
        assert_eq!(m.sensors(true), [local_map, Need { sensor: Sensor::Imu, rate: None }]);
        assert_eq!(Metadata::parse(m.to_text().as_bytes()).unwrap(), m);
        assert_eq!(parse("").unwrap().sensors(false), Need::DEFAULT);
        // What is needed without maps comes on top where they are missing, and nowhere else.
        let m = parse("need-without-maps: local-map 5\nneed-without-maps: pose 10\n").unwrap();
        assert_eq!(m.sensors(true), Need::DEFAULT);
        assert_eq!(m.sensors(false), [Need::DEFAULT, &[local_map]].concat());
        assert_eq!(Metadata::parse(m.to_text().as_bytes()).unwrap(), m);
        let reason = |needs: &str| parse(needs).unwrap_err().to_string();
        assert_eq!(
            reason("need: radar\n"),
            "line 5 asks for a sensor: there is no sensor `radar`; there are pose, imu, wheel-odometry, gnss, lidar, depth, \
             local-map"
        );
        for rate in ["30", "0", "-1", "200", "nan", "often"] {
            let text = reason(&format!("need: lidar {rate}\n"));
            assert!(text.contains(&format!("lidar can't be read {rate} times a second")), "{text}");
        }
        assert_eq!(reason("need: imu\nneed: imu 10\n"), "line 6 asks for a sensor: imu is asked for twice");
    }

    #[test]
    fn control_periods_are_positive_multiples_of_a_millisecond() {
        assert!([0.001, 0.005, 0.05, 0.1, 0.123, 1.0, 0.3].into_iter().all(is_control_period));
        assert!(![0.0, -0.1, 0.0015, 0.05001, f64::NAN, f64::INFINITY].into_iter().any(is_control_period));
    }

    #[test]
    fn names_are_fit_for_files() {
        assert!(["pid", "mppi-6", "a_b"].into_iter().all(is_name));
        assert!(!["", "Pid", "a/b", "a b", "é"].into_iter().any(is_name));
        let text = b"abi: 0.1\nname: ../../x\nversion: 1\ncontrol-period: 0.1\n";
        let error = MetadataError::BadLine { line: 2, text: "name: ../../x".into() };
        assert_eq!(Metadata::parse(text), Err(error));
    }
}
