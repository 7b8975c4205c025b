//! The data of the interface as its WIT declares them, reduced to what the outputs need.

use std::path::Path;

use wit_parser::{Resolve, Type as WitType, TypeDefKind, TypeId};

/// A type of the interface.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Type {
    F64,
    F32,
    U8,
    U32,
    U64,
    Bool,
    Text,
    Record(String),
    Enum(String),
    List(Box<Type>),
    Option(Box<Type>),
}

/// A field of a record, or a case of an enum, which has no type.
#[derive(Clone, Debug)]
pub(crate) struct Field {
    /// As WIT writes it: words with hyphens.
    pub(crate) name: String,
    pub(crate) docs: String,
    pub(crate) ty: Type,
}

#[derive(Clone, Debug)]
pub(crate) struct Record {
    pub(crate) name: String,
    pub(crate) docs: String,
    pub(crate) fields: Vec<Field>,
}

#[derive(Clone, Debug)]
pub(crate) struct Enum {
    pub(crate) name: String,
    pub(crate) docs: String,
    /// Name and docs of each case.
    pub(crate) cases: Vec<(String, String)>,
}

#[derive(Clone, Debug)]
pub(crate) enum Item {
    Record(Record),
    Enum(Enum),
}

/// All data of the interface, in the order of the text.
#[derive(Clone, Debug)]
pub(crate) struct Model {
    /// Major and minor number.
    pub(crate) version: (u64, u64),
    pub(crate) items: Vec<Item>,
}

impl Model {
    /// Reads the package in a folder.
    pub(crate) fn read(folder: &Path) -> Result<Self, String> {
        let mut resolve = Resolve::default();
        let (package, _) = resolve.push_dir(folder).map_err(|e| format!("{}: {e:#}", folder.display()))?;
        let package = &resolve.packages[package];
        let version = package.name.version.as_ref().ok_or("the package has no version")?;
        let types = package.interfaces.get("types").ok_or("the package has no interface `types`")?;
        let mut items = Vec::new();
        for (name, id) in &resolve.interfaces[*types].types {
            items.push(item(&resolve, name, *id)?);
        }
        Ok(Self { version: (version.major, version.minor), items })
    }

    /// The records in the order of the text.
    pub(crate) fn records(&self) -> impl Iterator<Item = &Record> {
        self.items.iter().filter_map(|item| match item {
            Item::Record(record) => Some(record),
            Item::Enum(_) => None,
        })
    }

    /// The enums in the order of the text.
    pub(crate) fn enums(&self) -> impl Iterator<Item = &Enum> {
        self.items.iter().filter_map(|item| match item {
            Item::Enum(e) => Some(e),
            Item::Record(_) => None,
        })
    }

    pub(crate) fn record(&self, name: &str) -> Result<&Record, String> {
        self.records().find(|r| r.name == name).ok_or_else(|| format!("there is no record `{name}`"))
    }

    /// Whether a record is a vector: nothing but two or three coordinates, and a heading.
    pub(crate) fn is_vector(&self, name: &str) -> bool {
        let coordinate = |f: &Field| f.ty == Type::F64 && ["x", "y", "z", "yaw"].contains(&f.name.as_str());
        self.records().any(|r| r.name == name && r.fields.iter().all(coordinate))
    }

    /// Whether a record holds nothing but numbers and records of numbers, so that it can be copied.
    pub(crate) fn is_plain(&self, name: &str) -> bool {
        self.records().filter(|r| r.name == name).flat_map(|r| &r.fields).all(|f| match &f.ty {
            Type::Record(inner) => self.is_plain(inner),
            Type::Text | Type::List(_) | Type::Option(_) => false,
            _ => true,
        })
    }
}

fn item(resolve: &Resolve, name: &str, id: TypeId) -> Result<Item, String> {
    let def = &resolve.types[id];
    let text = |docs: &wit_parser::Docs, of: &str| {
        docs.contents
            .as_deref()
            .map(|t| t.trim().to_owned())
            .ok_or_else(|| format!("`{of}` has no description"))
    };
    let docs = text(&def.docs, name)?;
    match &def.kind {
        TypeDefKind::Record(record) => {
            let field = |f: &wit_parser::Field| {
                let place = format!("{name}.{}", f.name);
                Ok(Field {
                    name: f.name.clone(),
                    docs: text(&f.docs, &place)?,
                    ty: ty(resolve, &f.ty, &place)?,
                })
            };
            let fields = record.fields.iter().map(field).collect::<Result<_, String>>()?;
            Ok(Item::Record(Record { name: name.to_owned(), docs, fields }))
        }
        TypeDefKind::Enum(e) => {
            let case = |c: &wit_parser::EnumCase| {
                Ok((c.name.clone(), text(&c.docs, &format!("{name}.{}", c.name))?))
            };
            let cases = e.cases.iter().map(case).collect::<Result<_, String>>()?;
            Ok(Item::Enum(Enum { name: name.to_owned(), docs, cases }))
        }
        other => Err(format!("`{name}` is a {}, for which there are no outputs yet", other.as_str())),
    }
}

fn ty(resolve: &Resolve, of: &WitType, place: &str) -> Result<Type, String> {
    Ok(match of {
        WitType::F64 => Type::F64,
        WitType::F32 => Type::F32,
        WitType::U8 => Type::U8,
        WitType::U32 => Type::U32,
        WitType::U64 => Type::U64,
        WitType::Bool => Type::Bool,
        WitType::String => Type::Text,
        WitType::Id(id) => {
            let def = &resolve.types[*id];
            let name = || def.name.clone().unwrap_or_default();
            match &def.kind {
                TypeDefKind::Record(_) => Type::Record(name()),
                TypeDefKind::Enum(_) => Type::Enum(name()),
                TypeDefKind::List(inner) => Type::List(Box::new(ty(resolve, inner, place)?)),
                TypeDefKind::Option(inner) => Type::Option(Box::new(ty(resolve, inner, place)?)),
                other => return Err(format!("{place}: no outputs yet for a {}", other.as_str())),
            }
        }
        other => return Err(format!("{place}: no outputs yet for the type {other:?}")),
    })
}

/// `goal-radius` as `goal_radius`.
pub(crate) fn snake(name: &str) -> String {
    name.replace('-', "_")
}

/// The same for what stands between backticks: names of fields have no spaces, as a command line has.
pub(crate) fn snake_if_name(text: &str) -> String {
    if text.contains(char::is_whitespace) { text.to_owned() } else { snake(text) }
}

/// `goal-radius` as `GoalRadius`.
pub(crate) fn camel(name: &str) -> String {
    name.split('-').map(|word| word[..1].to_uppercase() + &word[1..]).collect()
}

/// Names of fields between backticks, as another language writes them; all other text stays.
pub(crate) fn with_names(docs: &str, rename: impl Fn(&str) -> String) -> String {
    let parts = docs.split('`').enumerate();
    parts
        .map(|(i, part)| if i % 2 == 1 { rename(part) } else { part.to_owned() })
        .collect::<Vec<_>>()
        .join("`")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_fields_are_rewritten_and_command_lines_are_not() {
        let docs = "Drawn by `vb-harness replay` within the `goal-radius`, row-major";
        let expected = "Drawn by `vb-harness replay` within the `goal_radius`, row-major";
        assert_eq!(with_names(docs, snake_if_name), expected);
    }
}
