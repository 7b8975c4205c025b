//! The C layout of the data for Rust: the structs of `vb_planner.h`, and the conversions from and to the SDK's types.

use std::fmt::Write as _;

use crate::HEADER;
use crate::model::{Enum, Model, Record, Type, camel, snake};
use crate::rust_types;

/// What a planner is given, from the outermost record.
const GIVEN: [&str; 2] = ["task", "observation"];
/// What a planner gives.
const TAKEN: [&str; 1] = ["command"];

pub(crate) fn write(model: &Model) -> Result<String, String> {
    let mut out = format!(
        "//! The structs of `sdk/c/vb_planner.h` as Rust lays them out, and the conversions between them and the SDK's \
         types.\n//!\n//! {HEADER}\n\n#![allow(missing_docs, reason = \"the fields are those of the SDK's types\")]\n#![allow(unused_variables, reason = \"not every struct needs memory of its own\")]\n\nuse \
         std::ffi::c_char;\nuse std::ptr;\n\nuse abi_stable::StableAbi;\n\nuse super::memory::{{Arena, slice, text}};\nuse \
         crate::types::*;\n"
    );
    for record in used(model, &[&GIVEN[..], &TAKEN[..]].concat())? {
        layout(&mut out, record);
    }
    for record in used(model, &[&GIVEN[..], &TAKEN[..]].concat())? {
        lower(&mut out, record);
        lift(&mut out, record);
    }
    for e in model.enums().filter(|e| e.name != "log-level") {
        enumeration(&mut out, e);
    }
    Ok(out)
}

/// The records that these ones hold, and they themselves, in the order of the text.
pub(crate) fn used<'a>(model: &'a Model, from: &[&str]) -> Result<Vec<&'a Record>, String> {
    fn visit(model: &Model, name: &str, found: &mut Vec<String>) -> Result<(), String> {
        if found.iter().any(|f| f == name) {
            return Ok(());
        }
        found.push(name.to_owned());
        for field in &model.record(name)?.fields {
            if let Some(inner) = record_in(&field.ty) {
                visit(model, inner, found)?;
            }
        }
        Ok(())
    }
    let mut found = Vec::new();
    for name in from {
        visit(model, name, &mut found)?;
    }
    Ok(model.records().filter(|r| found.contains(&r.name)).collect())
}

/// The record that a type is, or holds.
fn record_in(ty: &Type) -> Option<&str> {
    match ty {
        Type::Record(name) => Some(name),
        Type::List(inner) | Type::Option(inner) => record_in(inner),
        _ => None,
    }
}

fn c(ty: &Type) -> String {
    match ty {
        Type::Bool => "u8".into(),
        Type::Enum(_) => "u32".into(),
        Type::Text => "*const c_char".into(),
        Type::Record(name) => format!("C{}", camel(name)),
        Type::List(inner) | Type::Option(inner) => format!("*const {}", c(inner)),
        plain => rust_types::rust(plain),
    }
}

fn layout(out: &mut String, r: &Record) {
    let _ = write!(
        out,
        "\n/// `vb_{}`.\n#[repr(C)]\n#[derive(Clone, Copy, Debug, StableAbi)]\npub struct C{} {{\n",
        snake(&r.name),
        camel(&r.name)
    );
    for f in &r.fields {
        let _ = writeln!(out, "    pub {}: {},", snake(&f.name), c(&f.ty));
        if matches!(f.ty, Type::List(_)) {
            let _ = writeln!(out, "    pub {}_len: usize,", snake(&f.name));
        }
    }
    out.push_str("}\n");
}

/// From the SDK's type: pointers lead into it, or into the arena.
fn lower(out: &mut String, r: &Record) {
    let _ = write!(
        out,
        "\n#[doc(hidden)]\n#[must_use]\npub fn lower_{0}(v: &{1}, arena: &mut Arena) -> C{1} {{\n    C{1} {{\n",
        snake(&r.name),
        camel(&r.name)
    );
    for f in &r.fields {
        let name = snake(&f.name);
        let value = match &f.ty {
            Type::Bool => format!("u8::from(v.{name})"),
            Type::Text => format!("arena.text(&v.{name})"),
            Type::Enum(_) => format!("v.{name} as u32"),
            Type::Record(inner) => format!("lower_{}(&v.{name}, arena)", snake(inner)),
            Type::Option(inner) => {
                let inner = snake(record_in(inner).unwrap_or_default());
                format!(
                    "match &v.{name} {{\n            Some(x) => {{\n                let x = lower_{inner}(x, arena);\n                \
                     arena.one(x)\n            }}\n            None => ptr::null(),\n        }}"
                )
            }
            Type::List(inner) => match record_in(inner) {
                Some(inner) => format!(
                    "{{\n            let list = v.{name}.iter().map(|x| lower_{}(x, arena)).collect();\n            \
                     arena.list(list)\n        }}",
                    snake(inner)
                ),
                None => format!("v.{name}.as_ptr()"),
            },
            _ => format!("v.{name}"),
        };
        let _ = writeln!(out, "        {name}: {value},");
        if matches!(f.ty, Type::List(_)) {
            let _ = writeln!(out, "        {name}_len: v.{name}.len(),");
        }
    }
    out.push_str("    }\n}\n");
}

/// To the SDK's type: everything is copied.
fn lift(out: &mut String, r: &Record) {
    let _ = write!(
        out,
        "\n/// # Safety\n/// All pointers lead to what the header says, or are null.\n///\n/// # Errors\n/// If an enum has none of \
         its values.\n#[doc(hidden)]\npub unsafe fn lift_{0}(c: &C{1}) -> Result<{1}, String> {{\n",
        snake(&r.name),
        camel(&r.name)
    );
    let _ = writeln!(out, "    Ok({} {{", camel(&r.name));
    let safety = "// SAFETY: by this function's own condition.";
    for f in &r.fields {
        let name = snake(&f.name);
        let value = match &f.ty {
            Type::Bool => format!("c.{name} != 0"),
            Type::Text => format!("unsafe {{ text(c.{name}) }}"),
            Type::Enum(e) => format!("lift_{}(c.{name})?", snake(e)),
            Type::Record(inner) => format!("unsafe {{ lift_{}(&c.{name}) }}?", snake(inner)),
            Type::Option(inner) => {
                let inner = snake(record_in(inner).unwrap_or_default());
                format!("unsafe {{ c.{name}.as_ref().map(|x| lift_{inner}(x)) }}.transpose()?")
            }
            Type::List(inner) => match record_in(inner) {
                Some(inner) => format!(
                    "unsafe {{ slice(c.{name}, c.{name}_len).iter().map(|x| lift_{}(x)).collect::<Result<_, _>>() }}?",
                    snake(inner)
                ),
                None => format!("unsafe {{ slice(c.{name}, c.{name}_len) }}.to_vec()"),
            },
            _ => format!("c.{name}"),
        };
        if value.contains("unsafe") {
            let _ = writeln!(out, "        {safety}");
        }
        let _ = writeln!(out, "        {name}: {value},");
    }
    out.push_str("    })\n}\n");
}

fn enumeration(out: &mut String, e: &Enum) {
    let (name, ty) = (snake(&e.name), camel(&e.name));
    let cases = e.cases.iter().enumerate().map(|(i, (case, _))| format!("{case} ({i})")).collect::<Vec<_>>();
    let wanted = match cases.split_last() {
        Some((last, rest)) => format!("{} or {last}", rest.join(", ")),
        None => String::new(),
    };
    let _ = write!(
        out,
        "\n/// # Errors\n/// If the number stands for nothing.\n#[doc(hidden)]\npub fn lift_{name}(value: u32) -> Result<{ty}, String> \
         {{\n    match value {{\n"
    );
    for (i, (case, _)) in e.cases.iter().enumerate() {
        let _ = writeln!(out, "        {i} => Ok({ty}::{}),", camel(case));
    }
    let _ = write!(
        out,
        "        other => Err(format!(\"{} is {{other}}; want {wanted}\")),\n    }}\n}}\n",
        e.name
    );
}
