//! The text header of an OpenCRG file: sections of parameters and the list of channels.

use std::collections::BTreeMap;

use super::super::Flaw;
use super::super::geotiff::number;

/// Sections whose content is for people, or is of no use here.
const IGNORED: [&str; 4] = ["CT", "ROAD_CRG_MPRO", "ROAD_CRG_MAP_PROJECTION", "ROAD_CRG_CT"];
const ROAD: &str = "ROAD_CRG";
const OPTIONS: &str = "ROAD_CRG_OPTS";
const MODIFIERS: &str = "ROAD_CRG_MODS";
const CHANNELS: &str = "KD_DEFINITION";

/// Number format of the data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Numbers {
    /// Text, numbers of this many characters.
    Text(usize),
    /// IEEE 754 with the most significant byte first, of this many bytes.
    Binary(usize),
}

/// Content of a column of the data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Channel {
    /// The heading of the segment before a cut, rad.
    Heading,
    /// The rise to the left over distance.
    Banking,
    /// The rise over distance of the segment before a cut.
    Slope,
    /// The longitudinal section with this number, counted from 1 at the right border.
    Section(u32),
    /// The longitudinal section at this coordinate v, m.
    At(f64),
}

/// A parameter and the line that gives it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Value {
    pub(super) value: f64,
    pub(super) line: usize,
}

/// Parameters of a section by their names in capitals.
pub(super) type Values = BTreeMap<String, Value>;

#[derive(Debug)]
pub(super) struct Header {
    pub(super) road: Values,
    pub(super) options: Values,
    /// `None` without a section of modifiers, for which other defaults apply than for an empty one.
    pub(super) modifiers: Option<Values>,
    pub(super) numbers: Numbers,
    /// The channels in the order of the columns, and the lines that define them.
    pub(super) channels: Vec<(Channel, usize)>,
    /// The number of lines of the header.
    pub(super) lines: usize,
    /// The number of its bytes.
    pub(super) bytes: usize,
}

pub(super) fn flaw(line: usize, problem: impl Into<String>) -> Flaw {
    Flaw::Line { line, problem: problem.into() }
}

impl Header {
    /// Reads the header at the start of a file.
    pub(super) fn read(bytes: &[u8]) -> Result<Self, Flaw> {
        let mut header = Self {
            road: Values::new(),
            options: Values::new(),
            modifiers: None,
            numbers: Numbers::Binary(4),
            channels: Vec::new(),
            lines: 0,
            bytes: 0,
        };
        let mut section = String::new();
        let mut seen = Vec::new();
        loop {
            let rest = &bytes[header.bytes..];
            let Some(end) = rest.iter().position(|b| *b == b'\n') else {
                return Err(Flaw::Truncated("its header has no end (a line that begins with $$)".to_owned()));
            };
            let text = String::from_utf8_lossy(&rest[..end]);
            header.bytes += end + 1;
            header.lines += 1;
            let line = text.trim_start_matches('\u{feff}').trim_end();
            if line.starts_with("$$") {
                break;
            }
            if let Some(name) = line.strip_prefix('$') {
                section = name.split('!').next().unwrap_or_default().trim().to_ascii_uppercase();
                header.enter(&section, &mut seen)?;
                continue;
            }
            let line = if line.starts_with('*') { "" } else { line.split('!').next().unwrap_or_default() };
            if !line.trim().is_empty() {
                header.take(&section, line.trim())?;
            }
        }
        for wanted in [ROAD, CHANNELS] {
            if !seen.iter().any(|name| name == wanted) {
                return Err(flaw(
                    header.lines,
                    format!("the header ends without the section ${wanted}: add it"),
                ));
            }
        }
        Ok(header)
    }

    /// Begins a section; a line of stars and blanks only ends one.
    fn enter(&mut self, section: &str, seen: &mut Vec<String>) -> Result<(), Flaw> {
        let line = self.lines;
        if section == "ROAD_CRG_FILE" {
            return Err(flaw(line, "the heights are in another file ($ROAD_CRG_FILE): give that file"));
        }
        let known = [ROAD, OPTIONS, MODIFIERS, CHANNELS].contains(&section) || IGNORED.contains(&section);
        if !known && section.chars().any(|c| c.is_ascii_alphabetic()) {
            return Err(flaw(line, format!("unknown section ${section}: remove it")));
        }
        if known && seen.iter().any(|name| name == section) {
            return Err(flaw(line, format!("duplicate section ${section}: remove one")));
        }
        if section == MODIFIERS {
            self.modifiers = Some(Values::new());
        }
        seen.push(section.to_owned());
        Ok(())
    }

    /// Takes a line of a section.
    fn take(&mut self, section: &str, text: &str) -> Result<(), Flaw> {
        let line = self.lines;
        let values = match section {
            ROAD => &mut self.road,
            OPTIONS => &mut self.options,
            MODIFIERS => self.modifiers.get_or_insert_default(),
            CHANNELS => return self.define(text),
            _ => return Ok(()),
        };
        let (name, value) = text
            .split_once('=')
            .ok_or_else(|| flaw(line, format!("{text:?} is not NAME = NUMBER, as required in ${section}")))?;
        let name = name.trim().to_ascii_uppercase();
        let number = number(&value.trim().replace(['D', 'd'], "E")).filter(|v| v.is_finite());
        let value =
            number.ok_or_else(|| flaw(line, format!("{name}: {:?} is not a number", value.trim())))?;
        if values.insert(name.clone(), Value { value, line }).is_some() {
            return Err(flaw(line, format!("duplicate {name}: remove one")));
        }
        Ok(())
    }

    /// Takes a line of the list of channels.
    fn define(&mut self, text: &str) -> Result<(), Flaw> {
        let line = self.lines;
        let (kind, rest) = text
            .split_once(':')
            .ok_or_else(|| flaw(line, format!("{text:?} is not a definition, e.g. D:long section 1,m")))?;
        match kind.trim().to_ascii_uppercase().as_str() {
            // Virtual channels are computed from others.
            "U" => Ok(()),
            "#" => {
                self.numbers = match rest.trim().to_ascii_uppercase().as_str() {
                    "LRFI" => Numbers::Text(10),
                    "LDFI" => Numbers::Text(20),
                    "KRBI" => Numbers::Binary(4),
                    "KDBI" => Numbers::Binary(8),
                    other => {
                        let problem = format!(
                            "the data format {other} is not supported: write LRFI, LDFI, KRBI or KDBI"
                        );
                        return Err(flaw(line, problem));
                    }
                };
                Ok(())
            }
            "D" => {
                let channel = channel(rest).map_err(|problem| flaw(line, problem))?;
                if self.channels.len() >= MOST_CHANNELS {
                    return Err(flaw(
                        line,
                        format!("more than {MOST_CHANNELS} channels: cut the road into parts"),
                    ));
                }
                self.channels.push((channel, line));
                Ok(())
            }
            other => Err(flaw(line, format!("{other:?} is not a kind of definition (D, U or #)"))),
        }
    }
}

/// The most channels, which bounds what a header can take.
const MOST_CHANNELS: usize = 1 << 16;

/// A channel by its name and unit.
fn channel(text: &str) -> Result<Channel, String> {
    let (name, unit) = text.rsplit_once(',').unwrap_or((text, ""));
    let name = name.split_whitespace().collect::<Vec<_>>().join(" ").to_ascii_lowercase();
    let unit = unit.trim().to_ascii_lowercase();
    let expected = |channel: Channel, wanted: &str| {
        if unit == wanted {
            Ok(channel)
        } else {
            Err(format!("{name:?} is in {unit:?}: convert it to {wanted}"))
        }
    };
    match name.as_str() {
        "reference line phi" => return expected(Channel::Heading, "rad"),
        "reference line banking" => return expected(Channel::Banking, "m/m"),
        "reference line slope" => return expected(Channel::Slope, "m/m"),
        _ => {}
    }
    let unknown = || {
        format!(
            "{name:?} is not a supported channel: reference line phi, banking or slope, long section N, or long section at v = V"
        )
    };
    let section = name.strip_prefix("long section").ok_or_else(unknown)?.trim();
    if let Some(v) = section.strip_prefix("at v") {
        let v =
            number(v.trim().trim_start_matches('=').trim()).filter(|v| v.is_finite()).ok_or_else(unknown)?;
        return expected(Channel::At(v), "m");
    }
    let number = section.parse().ok().filter(|n| *n > 0).ok_or_else(unknown)?;
    expected(Channel::Section(number), "m")
}
