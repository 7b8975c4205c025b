//! The conversions between the SDK's types and those that are generated from the WIT for components: in the planner, and
//! in the harness.

use std::fmt::Write as _;

use crate::HEADER;
use crate::c_layout::used;
use crate::model::{Model, Record, Type, camel, snake};

/// Which types a conversion starts from, and how it gets their values.
#[derive(Clone, Copy)]
enum From {
    /// From borrowed values of the first types, which are copied.
    Borrowed,
    /// From owned values, which are taken apart.
    Owned,
}

/// In a planner: what it is given becomes the SDK's, its command becomes the component's.
pub(crate) fn guest(model: &Model) -> Result<String, String> {
    let mut out = format!(
        "//! Between the SDK's types and those of the component's bindings.\n//!\n//! {HEADER}\n\nuse \
         super::bindings::vertibench::planner::types;\nuse crate::types::*;\n"
    );
    for record in used(model, &["task", "observation"])? {
        conversion(&mut out, record, From::Owned, "types::", "");
    }
    for e in enums(model, &["task", "observation"])? {
        enumeration(&mut out, model, &e, "types::", "")?;
    }
    for record in used(model, &["command"])? {
        conversion(&mut out, record, From::Owned, "", "types::");
    }
    for e in enums(model, &["command"])? {
        enumeration(&mut out, model, &e, "", "types::")?;
    }
    Ok(out)
}

/// In the harness: the other way round.
pub(crate) fn host(model: &Model) -> Result<String, String> {
    let mut out = format!(
        "//! Between the SDK's types and those of the bindings for version {}.{}.\n//!\n//! {HEADER}\n\nuse \
         super::bindings::vertibench::planner::types;\n",
        model.version.0, model.version.1
    );
    for record in used(model, &["task", "observation"])? {
        conversion(&mut out, record, From::Borrowed, "vb_sdk::", "types::");
    }
    for e in enums(model, &["task", "observation"])? {
        enumeration(&mut out, model, &e, "vb_sdk::", "types::")?;
    }
    for record in used(model, &["command"])? {
        conversion(&mut out, record, From::Owned, "types::", "vb_sdk::");
    }
    for e in enums(model, &["command"])? {
        enumeration(&mut out, model, &e, "types::", "vb_sdk::")?;
    }
    Ok(out)
}

/// Names of the enums that these records hold.
fn enums(model: &Model, of: &[&str]) -> Result<Vec<String>, String> {
    let mut names = Vec::new();
    for field in used(model, of)?.iter().flat_map(|r| &r.fields) {
        if let Type::Enum(name) = &field.ty
            && !names.contains(name)
        {
            names.push(name.clone());
        }
    }
    Ok(names)
}

fn conversion(out: &mut String, r: &Record, from: From, source: &str, target: &str) {
    let name = camel(&r.name);
    let reference = if matches!(from, From::Borrowed) { "&" } else { "" };
    let _ = write!(
        out,
        "\nimpl From<{reference}{source}{name}> for {target}{name} {{\n    fn from(v: {reference}{source}{name}) -> Self {{\n        \
         Self {{\n"
    );
    for f in &r.fields {
        let _ = writeln!(out, "            {}: {},", snake(&f.name), value(&f.ty, &snake(&f.name), from));
    }
    out.push_str("        }\n    }\n}\n");
}

fn value(ty: &Type, name: &str, from: From) -> String {
    let borrowed = matches!(from, From::Borrowed);
    match ty {
        Type::Enum(_) => format!("v.{name}.into()"),
        Type::Record(_) if borrowed => format!("(&v.{name}).into()"),
        Type::Record(_) => format!("v.{name}.into()"),
        Type::Text if borrowed => format!("v.{name}.clone()"),
        Type::List(inner) => match **inner {
            Type::Record(_) if borrowed => format!("v.{name}.iter().map(Into::into).collect()"),
            Type::Record(_) => format!("v.{name}.into_iter().map(Into::into).collect()"),
            _ if borrowed => format!("v.{name}.clone()"),
            _ => format!("v.{name}"),
        },
        Type::Option(_) if borrowed => format!("v.{name}.as_ref().map(Into::into)"),
        Type::Option(_) => format!("v.{name}.map(Into::into)"),
        _ => format!("v.{name}"),
    }
}

fn enumeration(
    out: &mut String,
    model: &Model,
    name: &str,
    source: &str,
    target: &str,
) -> Result<(), String> {
    let e = model.enums().find(|e| e.name == name).ok_or_else(|| format!("there is no enum `{name}`"))?;
    let ty = camel(name);
    let _ = write!(
        out,
        "\nimpl From<{source}{ty}> for {target}{ty} {{\n    fn from(v: {source}{ty}) -> Self {{\n        match v {{\n"
    );
    for (case, _) in &e.cases {
        let case = camel(case);
        let _ = writeln!(out, "            {source}{ty}::{case} => Self::{case},");
    }
    out.push_str("        }\n    }\n}\n");
    Ok(())
}
