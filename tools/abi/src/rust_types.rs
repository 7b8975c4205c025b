//! The SDK's types for Rust.

use std::fmt::Write as _;

use crate::HEADER;
use crate::model::{Enum, Item, Model, Record, Type, camel, snake, snake_if_name, with_names};

/// Maps are one generic type with methods, written by hand; the text of WIT knows no generics.
const ALIASES: [(&str, &str); 2] = [("height-map", "Map<f32>"), ("label-map", "Map<u8>")];
/// What the SDK defines beside its functions.
const ELSEWHERE: [&str; 1] = ["log-level"];

/// The name of a type of the interface in Rust.
pub(crate) fn rust(ty: &Type) -> String {
    match ty {
        Type::F64 => "f64".into(),
        Type::F32 => "f32".into(),
        Type::U8 => "u8".into(),
        Type::U32 => "u32".into(),
        Type::U64 => "u64".into(),
        Type::Bool => "bool".into(),
        Type::Text => "String".into(),
        Type::Record(name) | Type::Enum(name) => camel(name),
        Type::List(inner) => format!("Vec<{}>", rust(inner)),
        Type::Option(inner) => format!("Option<{}>", rust(inner)),
    }
}

pub(crate) fn write(model: &Model) -> String {
    let (major, minor) = model.version;
    let mut out = format!(
        "//! The data that pass between the harness and a planner, as `wit/v{major}_{minor}/planner.wit` declares them. Units are SI, \
         angles\n//! radians, body axes x forward, y left, z up.\n//!\n//! {HEADER}\n\n#[cfg(feature = \"serde\")]\nuse \
         serde::{{Deserialize, Serialize}};\n\npub use crate::map::Map;\n"
    );
    for item in &model.items {
        match item {
            Item::Record(r) => match ALIASES.iter().find(|(name, _)| *name == r.name) {
                Some((name, alias)) => {
                    docs(&mut out, "\n", "", &r.docs);
                    let _ = writeln!(out, "pub type {} = {alias};", camel(name));
                }
                None => record(&mut out, model, r),
            },
            Item::Enum(e) if ELSEWHERE.contains(&e.name.as_str()) => {}
            Item::Enum(e) => enumeration(&mut out, e),
        }
    }
    out
}

fn docs(out: &mut String, before: &str, indent: &str, text: &str) {
    out.push_str(before);
    for line in with_names(text, snake_unless_named).lines() {
        let _ = writeln!(out, "{}", format!("{indent}/// {line}").trim_end());
    }
}

/// Names of fields in docs; names of sensors and files keep their hyphens.
fn snake_unless_named(text: &str) -> String {
    if ["wheel-odometry", "local-map"].contains(&text) || text.contains('/') {
        text.to_owned()
    } else {
        snake_if_name(text)
    }
}

fn record(out: &mut String, model: &Model, r: &Record) {
    docs(out, "\n", "", &r.docs);
    let copy = if model.is_plain(&r.name) { "Clone, Copy" } else { "Clone" };
    let _ = writeln!(out, "#[derive({copy}, Debug, Default, PartialEq)]");
    out.push_str("#[cfg_attr(feature = \"serde\", derive(Serialize, Deserialize))]\n");
    if model.is_vector(&r.name) {
        let n = r.fields.len();
        let _ = writeln!(
            out,
            "#[cfg_attr(feature = \"serde\", serde(from = \"[f64; {n}]\", into = \"[f64; {n}]\"))]"
        );
    }
    let _ = writeln!(out, "pub struct {} {{", camel(&r.name));
    for f in &r.fields {
        docs(out, "", "    ", &f.docs);
        if let Type::List(inner) = &f.ty
            && matches!(**inner, Type::F32 | Type::U8)
        {
            out.push_str("    #[cfg_attr(feature = \"serde\", serde(with = \"crate::bytes\"))]\n");
        }
        // What planners of the first version don't send.
        if r.name == "command" && matches!(f.ty, Type::Enum(_) | Type::List(_)) {
            out.push_str("    #[cfg_attr(feature = \"serde\", serde(default))]\n");
        }
        let _ = writeln!(out, "    pub {}: {},", snake(&f.name), rust(&f.ty));
    }
    out.push_str("}\n");
    if model.is_vector(&r.name) {
        vector(out, r);
    }
}

/// Vectors cross as arrays.
fn vector(out: &mut String, r: &Record) {
    let (name, n) = (camel(&r.name), r.fields.len());
    let names = r.fields.iter().map(|f| snake(&f.name)).collect::<Vec<_>>();
    let list = names.join(", ");
    let values = names.iter().map(|f| format!("v.{f}")).collect::<Vec<_>>().join(", ");
    let _ = write!(
        out,
        "\nimpl From<[f64; {n}]> for {name} {{\n    fn from([{list}]: [f64; {n}]) -> Self {{\n        Self {{ {list} }}\n    \
         }}\n}}\n\nimpl From<{name}> for [f64; {n}] {{\n    fn from(v: {name}) -> Self {{\n        [{values}]\n    }}\n}}\n"
    );
}

fn enumeration(out: &mut String, e: &Enum) {
    docs(out, "\n", "", &e.docs);
    out.push_str("#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]\n");
    out.push_str("#[cfg_attr(feature = \"serde\", derive(Serialize, Deserialize), serde(rename_all = \"kebab-case\"))]\n");
    let _ = writeln!(out, "pub enum {} {{", camel(&e.name));
    for (i, (case, text)) in e.cases.iter().enumerate() {
        docs(out, "", "    ", text);
        if i == 0 {
            out.push_str("    #[default]\n");
        }
        let _ = writeln!(out, "    {},", camel(case));
    }
    out.push_str("}\n");
}
