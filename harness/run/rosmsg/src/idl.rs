//! Definitions of messages (`.msg`): parsing, the type hash of REP 2016, and Rust source.
//!
//! The subset is that of the folder `msg`: primitive types, texts, other messages, arrays of fixed size, unbounded sequences, and
//! constants. Bounded texts and sequences, default values and services are errors.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::Path;

use sha2::{Digest as _, Sha256};

/// The error of a definition: which one, and what is wrong with it.
#[derive(Debug, thiserror::Error)]
#[error("{message}: {reason}")]
pub struct IdlError {
    /// The name of the message, e.g. `geometry_msgs/msg/Twist`, or a path.
    pub message: String,
    /// What is wrong, with the line.
    pub reason: String,
}

/// Primitive types: name, `FIELD_TYPE_…` of `type_description_interfaces/msg/FieldType`, and the type in Rust.
const PRIMITIVES: [(&str, u8, &str); 14] = [
    ("int8", 2, "i8"),
    ("uint8", 3, "u8"),
    ("int16", 4, "i16"),
    ("uint16", 5, "u16"),
    ("int32", 6, "i32"),
    ("uint32", 7, "u32"),
    ("int64", 8, "i64"),
    ("uint64", 9, "u64"),
    ("float32", 10, "f32"),
    ("float64", 11, "f64"),
    ("char", 13, "u8"),
    ("bool", 15, "bool"),
    ("byte", 16, "u8"),
    ("string", 17, "std::string::String"),
];
/// `FIELD_TYPE_NESTED_TYPE`, and what arrays and unbounded sequences add to the identifier of their elements.
const NESTED: u8 = 1;
const ARRAY: u8 = 48;
const SEQUENCE: u8 = 144;

/// How many values a field has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Count {
    One,
    Array(u64),
    Sequence,
}

#[derive(Clone, Debug, PartialEq, Eq)]
struct Field {
    name: String,
    /// A primitive type, or the full name of a message.
    base: String,
    count: Count,
}

#[derive(Clone, Debug, PartialEq, Eq)]
struct Constant {
    name: String,
    base: String,
    value: String,
}

#[derive(Clone, Debug, PartialEq, Eq)]
struct Definition {
    fields: Vec<Field>,
    constants: Vec<Constant>,
    /// The lines without comments and blanks.
    text: String,
}

/// A set of definitions that name only each other.
#[derive(Clone, Debug, Default)]
pub struct Definitions(BTreeMap<String, Definition>);

impl Definitions {
    /// Reads all files `PACKAGE/TYPE.msg` of a folder.
    ///
    /// # Errors
    /// Returns an error if a file cannot be read or parsed, or names a type without a definition.
    pub fn load(folder: &Path) -> Result<Self, IdlError> {
        let io = |path: &Path| {
            let message = path.display().to_string();
            move |e: std::io::Error| IdlError { message, reason: e.to_string() }
        };
        let mut all = Self::default();
        for package in std::fs::read_dir(folder).map_err(io(folder))? {
            let package = package.map_err(io(folder))?.path();
            for file in std::fs::read_dir(&package).map_err(io(&package))? {
                let file = file.map_err(io(&package))?.path();
                let name = |path: &Path| path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
                let text = std::fs::read_to_string(&file).map_err(io(&file))?;
                all.add(&name(&package), &name(&file), &text)?;
            }
        }
        all.check()?;
        Ok(all)
    }

    /// Adds the definition of a message.
    ///
    /// # Errors
    /// Returns an error if a line cannot be parsed.
    pub fn add(&mut self, package: &str, name: &str, text: &str) -> Result<(), IdlError> {
        let message = format!("{package}/msg/{name}");
        let definition = parse(package, text).map_err(|(line, reason)| IdlError {
            message: message.clone(),
            reason: format!("line {line}: {reason}"),
        })?;
        self.0.insert(message, definition);
        Ok(())
    }

    /// Checks that each type that is named has a definition, and none contains itself.
    ///
    /// # Errors
    /// Returns the first that is missing, or the message that contains itself.
    pub fn check(&self) -> Result<(), IdlError> {
        for name in self.0.keys() {
            let used = self.referenced(name)?;
            if used.contains(name.as_str()) {
                return Err(IdlError { message: name.clone(), reason: "it contains itself".into() });
            }
        }
        Ok(())
    }

    /// The full names of all messages.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.0.keys().map(String::as_str)
    }

    fn get(&self, name: &str, wanted_by: &str) -> Result<&Definition, IdlError> {
        self.0.get(name).ok_or_else(|| IdlError {
            message: wanted_by.to_owned(),
            reason: format!("it names {name}, which has no definition"),
        })
    }

    /// The full names of all messages that a message names, and those that these name.
    fn referenced<'a>(&'a self, name: &'a str) -> Result<BTreeSet<&'a str>, IdlError> {
        let (mut found, mut open) = (BTreeSet::new(), vec![name]);
        while let Some(next) = open.pop() {
            for field in &self.get(next, name)?.fields {
                if primitive(&field.base).is_none() && found.insert(field.base.as_str()) {
                    open.push(&field.base);
                }
            }
        }
        Ok(found)
    }

    /// The type hash of REP 2016 (`rosidl_generator_type_description`): SHA-256 of the type description as JSON.
    ///
    /// # Errors
    /// Returns an error if a type has no definition.
    pub fn hash(&self, name: &str) -> Result<String, IdlError> {
        let mut json = String::from("{\"type_description\": ");
        self.describe(name, &mut json)?;
        json.push_str(", \"referenced_type_descriptions\": [");
        for (k, referenced) in self.referenced(name)?.into_iter().enumerate() {
            json.push_str(if k > 0 { ", " } else { "" });
            self.describe(referenced, &mut json)?;
        }
        json.push_str("]}");
        let digits = Sha256::digest(json).iter().fold(String::new(), |mut text, byte| {
            let _ = write!(text, "{byte:02x}");
            text
        });
        Ok(format!("RIHS01_{digits}"))
    }

    /// Appends the description of one type as `json.dumps` of Python writes it. Names are ASCII, so nothing needs an escape.
    fn describe(&self, name: &str, json: &mut String) -> Result<(), IdlError> {
        let _ = write!(json, "{{\"type_name\": \"{name}\", \"fields\": [");
        for (k, field) in self.get(name, name)?.fields.iter().enumerate() {
            let (id, nested) = match primitive(&field.base) {
                Some((_, id, _)) => (id, ""),
                None => (NESTED, field.base.as_str()),
            };
            let (id, capacity) = match field.count {
                Count::One => (id, 0),
                Count::Array(n) => (id + ARRAY, n),
                Count::Sequence => (id + SEQUENCE, 0),
            };
            let _ = write!(
                json,
                "{}{{\"name\": \"{}\", \"type\": {{\"type_id\": {id}, \"capacity\": {capacity}, \"string_capacity\": 0, \
                 \"nested_type_name\": \"{nested}\"}}}}",
                if k > 0 { ", " } else { "" },
                field.name,
            );
        }
        json.push_str("]}");
        Ok(())
    }

    /// The definition of a message with those of all types that it names, as bags have it: parts under a line of 80 `=` and a line
    /// `MSG: package/Type`.
    ///
    /// # Errors
    /// Returns an error if a type has no definition.
    pub fn text(&self, name: &str) -> Result<String, IdlError> {
        let mut text = self.get(name, name)?.text.clone();
        for referenced in self.referenced(name)? {
            let short = referenced.replacen("/msg/", "/", 1);
            let _ = write!(text, "{}\nMSG: {short}\n{}", "=".repeat(80), self.get(referenced, name)?.text);
        }
        Ok(text)
    }

    /// Rust source with a module for each package and a type for each message.
    ///
    /// # Errors
    /// Returns an error if a type has no definition.
    pub fn rust(&self) -> Result<String, IdlError> {
        let mut packages: BTreeMap<&str, Vec<(&str, &str)>> = BTreeMap::new();
        for name in self.0.keys() {
            if let Some((package, short)) = name.split_once("/msg/") {
                packages.entry(package).or_default().push((name, short));
            }
        }
        let mut out = String::from(
            "//! The messages of the folder `msg`, a module for each package.\n//!\n//! Generated by `cargo run --package vb-rosmsg \
             --example generate`; do not edit.\n",
        );
        for (package, messages) in packages {
            let _ = write!(
                out,
                "\n/// Messages of the package `{package}`.\npub mod {package} {{\n    use serde::{{Deserialize, Serialize}};\n"
            );
            for (name, short) in messages {
                self.rust_type(name, package, short, &mut out)?;
            }
            out.push_str("}\n");
        }
        Ok(out)
    }

    fn rust_type(&self, name: &str, package: &str, short: &str, out: &mut String) -> Result<(), IdlError> {
        let definition = self.get(name, name)?;
        let _ = write!(
            out,
            "\n    /// `{name}`.\n    #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]\n    pub struct {short} {{\n"
        );
        for field in &definition.fields {
            let base = match primitive(&field.base) {
                Some((_, _, rust)) => rust.to_owned(),
                None => format!("super::{}", field.base.replacen("/msg/", "::", 1)),
            };
            let kind = match field.count {
                Count::One => base,
                Count::Array(n) => format!("crate::Array<{base}, {n}>"),
                Count::Sequence => format!("Vec<{base}>"),
            };
            if kind == "Vec<u8>" {
                out.push_str("        #[serde(with = \"serde_bytes\")]\n");
            }
            let _ = writeln!(out, "        pub {}: {kind},", field.name);
        }
        out.push_str("    }\n");
        if !definition.constants.is_empty() {
            let _ = write!(out, "\n    impl {short} {{\n");
            for Constant { name, base, value } in &definition.constants {
                let kind = primitive(base).map_or("i64", |(_, _, rust)| rust);
                let _ = writeln!(out, "        pub const {name}: {kind} = {value};");
            }
            out.push_str("    }\n");
        }
        let _ = write!(
            out,
            "\n    impl crate::Message for {short} {{\n        const PACKAGE: &str = \"{package}\";\n        const TYPE: &str = \
             \"{short}\";\n        const NAME: &str = \"{name}\";\n        const HASH: &str = \"{}\";\n        const DEFINITION: &str = \
             {:?};\n    }}\n",
            self.hash(name)?,
            self.text(name)?,
        );
        Ok(())
    }
}

fn primitive(name: &str) -> Option<(&'static str, u8, &'static str)> {
    PRIMITIVES.into_iter().find(|(known, ..)| *known == name)
}

/// Parses a definition; the error has the number of the line, from 1.
fn parse(package: &str, text: &str) -> Result<Definition, (usize, String)> {
    let mut definition = Definition { fields: Vec::new(), constants: Vec::new(), text: String::new() };
    for (k, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or_default().trim();
        if line.is_empty() {
            continue;
        }
        let wrong = |reason: String| (k + 1, reason);
        let (kind, rest) = line
            .split_once(char::is_whitespace)
            .ok_or_else(|| wrong(format!("`{line}` has no name; want TYPE NAME")))?;
        let rest = rest.trim();
        definition.text.extend([line, "\n"]);
        if let Some((name, value)) = rest.split_once('=') {
            let (name, value) = (name.trim().to_owned(), value.trim().to_owned());
            if value.parse::<i64>().is_err() || primitive(kind).is_none() {
                return Err(wrong(format!(
                    "the constant `{name}` is not a whole number of a primitive type"
                )));
            }
            definition.constants.push(Constant {
                name: identifier(&name).map_err(wrong)?,
                base: kind.to_owned(),
                value,
            });
            continue;
        }
        let (base, count) = match kind.strip_suffix(']').and_then(|kind| kind.split_once('[')) {
            None => (kind, Count::One),
            Some((base, "")) => (base, Count::Sequence),
            Some((base, size)) => match size.parse() {
                Ok(n) if n > 0 => (base, Count::Array(n)),
                _ => return Err(wrong(format!("the size of `{kind}` is not supported; want [] or [N]"))),
            },
        };
        let base = match (primitive(base), base.split_once('/')) {
            (Some(_), _) => base.to_owned(),
            (None, Some((package, name))) => {
                format!("{}/msg/{}", identifier(package).map_err(wrong)?, identifier(name).map_err(wrong)?)
            }
            (None, None) => format!("{package}/msg/{}", identifier(base).map_err(wrong)?),
        };
        definition.fields.push(Field { name: identifier(rest).map_err(wrong)?, base, count });
    }
    Ok(definition)
}

/// A name of a field, type, package or constant.
fn identifier(name: &str) -> Result<String, String> {
    let good = name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    good.then(|| name.to_owned()).ok_or_else(|| format!("`{name}` is not a name"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_supported_is_named_with_its_line() {
        let said = |text: &str| Definitions::default().add("p", "M", text).unwrap_err().to_string();
        assert_eq!(said("float64 x\nfloat64"), "p/msg/M: line 2: `float64` has no name; want TYPE NAME");
        assert_eq!(said("string<=5 name"), "p/msg/M: line 1: `string<=5` is not a name");
        assert_eq!(
            said("uint8[<=5] x"),
            "p/msg/M: line 1: the size of `uint8[<=5]` is not supported; want [] or [N]"
        );
        assert_eq!(said("float64 x 1.0"), "p/msg/M: line 1: `x 1.0` is not a name");
        assert_eq!(
            said("uint8 X=a"),
            "p/msg/M: line 1: the constant `X` is not a whole number of a primitive type"
        );
    }

    #[test]
    fn a_type_without_a_definition_and_one_that_contains_itself_are_refused() {
        let mut all = Definitions::default();
        all.add("p", "A", "B b # within the package\n").unwrap();
        assert_eq!(
            all.check().unwrap_err().to_string(),
            "p/msg/A: it names p/msg/B, which has no definition"
        );
        all.add("p", "B", "A[] a").unwrap();
        assert_eq!(all.check().unwrap_err().to_string(), "p/msg/A: it contains itself");
    }
}
