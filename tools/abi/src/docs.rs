//! The tables of the documentation.

use std::fmt::Write as _;

use crate::c_layout::used;
use crate::model::{Model, Type, snake};

/// A table for each record and enum, for `docs/abi.md`.
pub(crate) fn tables(model: &Model) -> Result<String, String> {
    let mut out = String::new();
    let mut records = used(model, &["task"])?;
    for more in ["observation", "command"] {
        for record in used(model, &[more])? {
            if !records.iter().any(|r| r.name == record.name) {
                records.push(record);
            }
        }
    }
    // What a planner meets first comes first.
    let order = ["task", "observation", "command"];
    records.sort_by_key(|r| order.iter().position(|name| *name == r.name).unwrap_or(order.len()));
    for record in records {
        let _ = write!(
            out,
            "### `{}`\n\n{}\n\n| field | type | meaning |\n|---|---|---|\n",
            record.name,
            one_line(&record.docs)
        );
        for f in &record.fields {
            let _ = writeln!(
                out,
                "| `{}` | {} | {} |",
                f.name,
                name(&f.ty),
                one_line(&f.docs).replace('|', "\\|")
            );
        }
        out.push('\n');
    }
    for e in model.enums().filter(|e| e.name != "log-level") {
        let _ = write!(
            out,
            "### `{}`\n\n{}\n\n| value | number in C | meaning |\n|---|---|---|\n",
            e.name,
            one_line(&e.docs)
        );
        for (i, (case, docs)) in e.cases.iter().enumerate() {
            let _ = writeln!(out, "| `{case}` | {i} | {} |", one_line(docs));
        }
        out.push('\n');
    }
    Ok(out)
}

/// The fields of each record as a sentence, for the page on the worker protocol.
pub(crate) fn wire(model: &Model) -> Result<String, String> {
    let mut out = String::new();
    for record in used(model, &["task", "observation", "command"])? {
        let fields =
            record.fields.iter().map(|f| format!("`{}` ({})", snake(&f.name), on_the_wire(model, &f.ty)));
        let list = if model.is_vector(&record.name) {
            format!("an array of {} numbers: {}", record.fields.len(), fields_of(record))
        } else {
            fields.collect::<Vec<_>>().join(", ")
        };
        let _ = writeln!(out, "- **{}**: {list}.", record.name);
    }
    out.push('\n');
    Ok(out)
}

fn fields_of(record: &crate::model::Record) -> String {
    record.fields.iter().map(|f| format!("`{}`", f.name)).collect::<Vec<_>>().join(", ")
}

fn on_the_wire(model: &Model, ty: &Type) -> String {
    match ty {
        Type::F64 | Type::F32 => "number".into(),
        Type::U8 | Type::U32 | Type::U64 => "integer".into(),
        Type::Bool => "boolean".into(),
        Type::Text => "text".into(),
        Type::Record(name) => name.clone(),
        Type::Enum(name) => {
            let cases = model.enums().filter(|e| e.name == *name).flat_map(|e| &e.cases);
            cases.map(|(case, _)| format!("`\"{case}\"`")).collect::<Vec<_>>().join(" or ")
        }
        Type::List(inner) => match **inner {
            Type::F32 => "binary: 32-bit floats".into(),
            Type::U8 => "binary: bytes".into(),
            _ => format!("array of {}", on_the_wire(model, inner)),
        },
        Type::Option(inner) => format!("{} or nil", on_the_wire(model, inner)),
    }
}

fn name(ty: &Type) -> String {
    match ty {
        Type::F64 => "`f64`".into(),
        Type::F32 => "`f32`".into(),
        Type::U8 => "`u8`".into(),
        Type::U32 => "`u32`".into(),
        Type::U64 => "`u64`".into(),
        Type::Bool => "`bool`".into(),
        Type::Text => "`string`".into(),
        Type::Record(name) | Type::Enum(name) => format!("[`{name}`](#{name})"),
        Type::List(inner) => format!("list of {}", name(inner)),
        Type::Option(inner) => format!("{}, or absent", name(inner)),
    }
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
