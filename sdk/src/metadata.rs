//! Plugin metadata, readable without running the plugin.
//!
//! [`export_planner!`](crate::export_planner) writes a text into a section of the file: the custom section
//! [`WASM_SECTION`] of the core WASM module, or the section [`ELF_SECTION`] of a native library. It is UTF-8 with one
//! `key: value` per line, in which `\\`, `\n` and `\r` are escaped by a backslash. `param` begins a parameter, to which
//! the following `default` and `help` belong. `need` names a sensor and optionally its rate, Hz: `need: lidar 10`; a
//! planner without `need` gets [`Need::DEFAULT`]. `need-without-maps` requests additional sensors for tasks in which
//! the perception profile omits a map. `model` names learned weights with their hash and the hashes of their training
//! data. Unknown keys are ignored, so that later versions can add keys.

use std::fmt;

/// The name of the custom section of a WASM plugin.
pub const WASM_SECTION: &str = "vb:planner";
/// The name of the section of a native plugin in ELF.
pub const ELF_SECTION: &str = ".vb.planner";
/// The name of the section of a native plugin in Mach-O.
pub const MACHO_SECTION: &str = "__vb_planner";

/// The metadata of a plugin.
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
    /// A one-sentence description of the planner.
    pub about: String,
    /// The control period, s: a multiple of 1 ms.
    pub control_period: f64,
    /// The parameters.
    pub params: Vec<ParamSpec>,
    /// The declared sensors. Empty for planners with the default sensors ([`Metadata::sensors`]).
    pub needs: Vec<Need>,
    /// Additional sensors for tasks in which the perception profile omits a map.
    pub needs_without_maps: Vec<Need>,
    /// The embedded learned weights, each with its hash and the hashes of its training data.
    pub models: Vec<String>,
}

macro_rules! sensors {
    ($($(#[$doc:meta])* $variant:ident = $name:literal;)*) => {
        /// A sensor. The field of [`Observation`](crate::Observation) with its name documents the measurement.
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
    /// Angular velocity and suspension travel of the wheels.
    WheelOdometry = "wheel-odometry";
    /// The GNSS position.
    Gnss = "gnss";
    /// The spinning lidar.
    Lidar = "lidar";
    /// The depth camera.
    Depth = "depth";
    /// The local map, built from lidar and depth camera.
    LocalMap = "local-map";
}

impl Sensor {
    /// The sensor with this name; `None` for an unknown name.
    #[must_use]
    pub fn find(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|sensor| sensor.name() == name)
    }
}

/// A requested sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Need {
    /// The sensor.
    pub sensor: Sensor,
    /// Its rate, Hz; `None` for the rate of the perception profile, or every step for pose and wheel odometry.
    pub rate: Option<f64>,
}

impl Need {
    /// The sensors of a planner that requests none.
    pub const DEFAULT: &[Self] =
        &[Self { sensor: Sensor::Pose, rate: None }, Self { sensor: Sensor::WheelOdometry, rate: None }];

    /// Adds a need to a list without duplicates.
    ///
    /// # Errors
    /// Returns a text for the errors of [`Need::parse`], and for a duplicate sensor.
    pub fn add(list: &mut Vec<Self>, text: &str) -> Result<(), String> {
        let need = Self::parse(text)?;
        if list.iter().any(|n| n.sensor == need.sensor) {
            return Err(format!("{} is requested twice", need.sensor.name()));
        }
        list.push(need);
        Ok(())
    }

    /// Parses `lidar` or `lidar 10`. Underscores are accepted in place of hyphens, because Rust names contain none.
    ///
    /// # Errors
    /// Returns a text with the error and the valid values.
    pub fn parse(text: &str) -> Result<Self, String> {
        let (name, rate) = text.split_once(' ').map_or((text, None), |(name, rate)| (name, Some(rate)));
        let sensor = Sensor::find(&name.replace('_', "-")).ok_or_else(|| {
            let known: Vec<&str> = Sensor::ALL.iter().map(|s| s.name()).collect();
            format!("unknown sensor `{name}`; sensors: {}", known.join(", "))
        })?;
        let rate = match rate.map(str::trim) {
            None => None,
            Some(text) => match text.parse() {
                Ok(rate) if is_rate(rate) => Some(rate),
                _ => {
                    return Err(format!(
                        "the rate `{text}` of {name} must be a divisor of 100 Hz, e.g. 100, 20, 10 or 5"
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

/// Whether a sensor supports this rate, Hz: the period must be a multiple of the sample interval of 10 ms.
#[must_use]
pub fn is_rate(rate: f64) -> bool {
    let samples = 100.0 / rate;
    let nearest = samples.round();
    (1.0..1e6).contains(&nearest) && (samples - nearest).abs() < 1e-6
}

/// A declared parameter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ParamSpec {
    /// The name of the parameter.
    pub key: String,
    /// The default value.
    pub default: String,
    /// The meaning of the parameter, with its unit.
    pub help: String,
}

/// The reason why a metadata text is invalid.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MetadataError {
    /// The text is not UTF-8.
    NotUtf8,
    /// A line is not `key: value`, or its value doesn't fit its key.
    BadLine {
        /// The number of the line, counted from 1.
        line: usize,
        /// The content of the line.
        text: String,
    },
    /// The requested sensor does not exist, has an invalid rate, or is a duplicate.
    BadNeed {
        /// The number of the line, counted from 1.
        line: usize,
        /// The error.
        reason: String,
    },
    /// A required key is missing.
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
            Self::BadNeed { line, reason } => write!(f, "line {line} requests a sensor: {reason}"),
            Self::Missing { key } => write!(f, "`{key}` is missing"),
        }
    }
}

impl std::error::Error for MetadataError {}

impl Metadata {
    /// The text of the section, as read by [`parse`](Self::parse). Authors' names must not contain a colon.
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

    /// The sensors that the planner receives: its needs, or [`Need::DEFAULT`], plus those for missing maps if the
    /// perception profile omits a map.
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

    /// Parses the text of the section.
    ///
    /// # Errors
    /// Returns an error for a text that violates the format of [the module](self).
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
                // Cargo joins the authors of a package with colons.
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

/// Whether this control period (s) is valid: a positive multiple of the simulation step of 1 ms.
#[must_use]
pub const fn is_control_period(seconds: f64) -> bool {
    let steps = seconds * 1000.0;
    // Decimal fractions of a second are not exact in binary; a millionth of a step is.
    let nearest = (steps + 0.5) as u64;
    let off = steps - nearest as f64;
    nearest > 0 && nearest < 1_000_000_000 && off < 1e-6 && off > -1e-6
}

/// Whether this is a valid planner name: one or more of `a-z`, `0-9`, `-` and `_`, because files contain it in their
/// names.
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

/// The text of a section from its keys and values, evaluated at compile time for a static.
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
        // Sensors for missing maps are added only if a map is missing.
        let m = parse("need-without-maps: local-map 5\nneed-without-maps: pose 10\n").unwrap();
        assert_eq!(m.sensors(true), Need::DEFAULT);
        assert_eq!(m.sensors(false), [Need::DEFAULT, &[local_map]].concat());
        assert_eq!(Metadata::parse(m.to_text().as_bytes()).unwrap(), m);
        let reason = |needs: &str| parse(needs).unwrap_err().to_string();
        assert_eq!(
            reason("need: radar\n"),
            "line 5 requests a sensor: unknown sensor `radar`; sensors: pose, imu, wheel-odometry, gnss, lidar, depth, \
             local-map"
        );
        for rate in ["30", "0", "-1", "200", "nan", "often"] {
            let text = reason(&format!("need: lidar {rate}\n"));
            assert!(text.contains(&format!("the rate `{rate}` of lidar must be")), "{text}");
        }
        assert_eq!(reason("need: imu\nneed: imu 10\n"), "line 6 requests a sensor: imu is requested twice");
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
