//! Vehicles as text.

use crate::{Imported, Kind};
use serde_json::Value;
use std::fmt::Write as _;

/// Width up to which a list or a map stands on one line.
const WIDTH: usize = 110;

/// Keys in the order of vehicle files; others follow by name.
const ORDER: &[&str] = &[
    "type",
    "model",
    "schema",
    "name",
    "description",
    "scale",
    "deviations",
    "length",
    "width",
    "height",
    "max_speed",
    "chassis",
    "axles",
    "steering",
    "tracks",
    "tyre",
    "tyres",
    "powertrain",
    "mass",
    "com",
    "seat",
    "inertia",
    "friction",
    "resistance",
    "wheel_faces",
    "hull",
    "position",
    "driven",
    "unsprung_mass",
    "spin_inertia",
    "brake_torque",
    "suspension",
    "linkage",
    "spindle",
    "struts",
    "chassis",
    "end",
    "part",
    "spring",
    "damper",
    "stops",
    "range",
    "engine",
    "converter",
    "governor",
    "gearbox",
    "driveline",
];

/// Lists that stand in the file even if they are empty.
const REQUIRED: &[&str] = &["hull", "links"];

/// The vehicle file with its comments.
pub(crate) fn file(imported: &Imported) -> String {
    let mut out = String::new();
    let _ = writeln!(out, "# Converted from {} by `vb-harness vehicle import`.", imported.source);
    let _ = writeln!(out, "# SI units: m, kg, s, N, rad. Chassis frame: x forward, y left, z up.");
    for (kind, head) in [
        (Kind::Chosen, "Choices:"),
        (Kind::Approximated, "Approximations:"),
        (Kind::Assumed, "Assumptions without values in the source:"),
        (Kind::NoCounterpart, "Values of the source without a counterpart:"),
    ] {
        let notes: Vec<_> = imported.notes.of(kind).collect();
        if notes.is_empty() {
            continue;
        }
        let _ = writeln!(out, "#\n# {head}");
        for note in notes {
            wrap(&mut out, &note.text);
        }
    }
    let mut value =
        serde_json::to_value(&imported.spec).expect("a vehicle has text keys and can be written as JSON");
    tidy(&mut value);
    map(&mut out, &value, 0);
    out
}

/// A note as comment lines.
fn wrap(out: &mut String, text: &str) {
    let mut line = String::from("# -");
    for word in text.split(' ') {
        if line.len() + word.len() > 118 {
            out.push_str(&line);
            out.push('\n');
            line = String::from("#  ");
        }
        line.push(' ');
        line.push_str(word);
    }
    out.push_str(&line);
    out.push('\n');
}

/// Removes empty fields, and digits beyond the ninth.
fn tidy(value: &mut Value) {
    match value {
        Value::Object(fields) => {
            fields.retain(|key, v| {
                let empty = v.as_array().is_some_and(Vec::is_empty)
                    || v.as_object().is_some_and(serde_json::Map::is_empty);
                !v.is_null() && (!empty || REQUIRED.contains(&key.as_str()))
            });
            fields.values_mut().for_each(tidy);
        }
        Value::Array(items) => items.iter_mut().for_each(tidy),
        Value::Number(n) => {
            if let Some(x) = n.as_f64().filter(|_| n.is_f64())
                && let Some(rounded) = format!("{x:.8e}").parse().ok().and_then(serde_json::Number::from_f64)
            {
                *n = rounded;
            }
        }
        _ => {}
    }
}

fn scalar(value: &Value) -> String {
    match value {
        Value::String(s) => {
            let plain = !s.is_empty()
                && s.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
                && s.chars().next().is_some_and(|c| c.is_ascii_alphabetic())
                && !matches!(
                    s.to_ascii_lowercase().as_str(),
                    "true" | "false" | "null" | "yes" | "no" | "on" | "off" | "y" | "n"
                );
            if plain { s.clone() } else { Value::String(s.clone()).to_string() }
        }
        other => other.to_string(),
    }
}

/// The value on one line.
fn flow(value: &Value) -> String {
    match value {
        Value::Array(items) => format!("[{}]", items.iter().map(flow).collect::<Vec<_>>().join(", ")),
        Value::Object(_) => {
            let fields: Vec<String> = ordered(value).map(|(k, v)| format!("{k}: {}", flow(v))).collect();
            format!("{{{}}}", fields.join(", "))
        }
        other => scalar(other),
    }
}

fn ordered(value: &Value) -> impl Iterator<Item = (&String, &Value)> {
    let mut fields: Vec<_> = value.as_object().into_iter().flatten().collect();
    fields.sort_by_key(|(k, _)| ORDER.iter().position(|o| o == k).unwrap_or(ORDER.len()));
    fields.into_iter()
}

/// Whether a value may stand on the line of its key.
fn fits(value: &Value, indent: usize, key: usize) -> bool {
    let deep = match value {
        Value::Object(m) => m.values().any(Value::is_object),
        Value::Array(items) => items.iter().any(Value::is_object),
        _ => false,
    };
    !deep && indent + key + flow(value).len() <= WIDTH
}

fn map(out: &mut String, value: &Value, indent: usize) {
    for (i, (key, field)) in ordered(value).enumerate() {
        // The first key of a list's item follows its dash.
        if i > 0 || indent == 0 || !out.ends_with("- ") {
            let _ = write!(out, "{:indent$}", "");
        }
        entry(out, key, field, indent);
    }
}

fn entry(out: &mut String, key: &str, value: &Value, indent: usize) {
    match value {
        Value::Object(m) if !m.is_empty() && !fits(value, indent, key.len() + 2) => {
            let _ = writeln!(out, "{key}:");
            map(out, value, indent + 2);
        }
        Value::Array(items) if !fits(value, indent, key.len() + 2) => {
            let _ = writeln!(out, "{key}:");
            list(out, items, indent + 2);
        }
        other => {
            let _ = writeln!(out, "{key}: {}", flow(other));
        }
    }
}

fn list(out: &mut String, items: &[Value], indent: usize) {
    for item in items {
        let _ = write!(out, "{:indent$}- ", "");
        match item {
            Value::Object(_) if !fits(item, indent, 2) => map(out, item, indent + 2),
            Value::Array(inner) if !fits(item, indent, 2) => {
                // A list in a list: its first item follows the dash.
                for (i, v) in inner.iter().enumerate() {
                    if i > 0 {
                        let _ = write!(out, "{:w$}", "", w = indent + 2);
                    }
                    let _ = writeln!(out, "- {}", flow(v));
                }
            }
            other => {
                let _ = writeln!(out, "{}", flow(other));
            }
        }
    }
}
