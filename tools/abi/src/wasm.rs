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
        enumeration(&mut out, model, model, &e, "types::", "")?;
    }
    for record in used(model, &["command"])? {
        conversion(&mut out, record, From::Owned, "", "types::");
    }
    for e in enums(model, &["command"])? {
        enumeration(&mut out, model, model, &e, "", "types::")?;
    }
    Ok(out)
}

/// In the harness: from the SDK's types, which are those of the newest version, to the bindings of a hosted version, and its commands
/// back. An older version leaves out the newest fields of tasks and observations, and its commands get their defaults.
///
/// # Errors
/// A sentence on what of the version has no counterpart in the newest one: such a conversion is written by hand.
pub(crate) fn host(version: &Model, newest: &Model) -> Result<String, String> {
    let mut out = format!(
        "//! Between the SDK's types and those of the bindings for version {}.{}.\n//!\n//! {HEADER}\n\nuse \
         super::bindings::vertibench::planner::types;\n",
        version.version.0, version.version.1
    );
    for record in used(version, &["task", "observation"])? {
        shared_fields(record, newest)?;
        conversion(&mut out, record, From::Borrowed, "vb_sdk::", "types::");
    }
    for e in enums(version, &["task", "observation"])? {
        enumeration(&mut out, newest, version, &e, "vb_sdk::", "types::")?;
    }
    for record in used(version, &["command"])? {
        let defaults = shared_fields(record, newest)? < newest.record(&record.name)?.fields.len();
        conversion_with(&mut out, record, From::Owned, "types::", "vb_sdk::", defaults);
    }
    for e in enums(version, &["command"])? {
        enumeration(&mut out, version, newest, &e, "types::", "vb_sdk::")?;
    }
    Ok(out)
}

/// The number of fields of an older record, each of which the newest one must have with the same type.
fn shared_fields(older: &Record, newest: &Model) -> Result<usize, String> {
    let new = newest.record(&older.name)?;
    for f in &older.fields {
        if !new.fields.iter().any(|n| n.name == f.name && n.ty == f.ty) {
            return Err(format!(
                "`{}.{}` has no field of this name and type in the newest version",
                older.name, f.name
            ));
        }
    }
    Ok(older.fields.len())
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
    conversion_with(out, r, from, source, target, false);
}

/// The conversion of a record, the rest of whose target has default values.
fn conversion_with(out: &mut String, r: &Record, from: From, source: &str, target: &str, defaults: bool) {
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
    if defaults {
        out.push_str("            ..Self::default()\n");
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

/// The conversion of an enum, whose target must have all cases of its source.
fn enumeration(
    out: &mut String,
    from: &Model,
    to: &Model,
    name: &str,
    source: &str,
    target: &str,
) -> Result<(), String> {
    let find = |model: &Model| {
        model.enums().find(|e| e.name == name).cloned().ok_or_else(|| format!("there is no enum `{name}`"))
    };
    let (e, target_cases) = (find(from)?, find(to)?.cases);
    let known = |case: &str| target_cases.iter().any(|(c, _)| c == case);
    if let Some((case, _)) = e.cases.iter().find(|(case, _)| !known(case)) {
        return Err(format!("case `{case}` of `{name}` can't be expressed in the other version"));
    }
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
