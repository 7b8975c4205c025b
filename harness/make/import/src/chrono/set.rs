//! The files of a set and their places.

use super::json::{Doc, Node};
use crate::{ImportError, MOST, Notes};
use std::cell::{OnceCell, RefCell};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// Levels above the vehicle's file in which the folder of the set is searched.
const LEVELS: usize = 8;
/// Entries of a set's folder that are looked at for engines, transmissions and tyres.
const ENTRIES: usize = 5000;
/// Depth to which a set's folder is searched.
const DEPTH: usize = 6;
/// Files of a set that are read.
const FILES: usize = 500;

/// The folders and the documents of a set.
#[derive(Debug)]
pub(crate) struct Set {
    /// The folder to which paths are relative.
    pub(crate) root: PathBuf,
    /// The folder of this vehicle's files within it.
    pub(crate) own: PathBuf,
    docs: RefCell<BTreeMap<PathBuf, Rc<Doc>>>,
    /// Path, type and template of the files in the own folder, by path.
    parts: OnceCell<Vec<[String; 3]>>,
}

impl Set {
    /// The set to which a vehicle's file belongs; `reference` is a path that stands in it.
    pub(crate) fn around(
        file: &Path,
        reference: Option<&str>,
        data: Option<&Path>,
    ) -> Result<Self, ImportError> {
        let full = std::fs::canonicalize(file).map_err(|e| ImportError::reading(file, &e))?;
        let reference = reference.unwrap_or("");
        let root = match data {
            Some(d) => d.to_owned(),
            None => full
                .ancestors()
                .skip(1)
                .take(LEVELS)
                .find(|folder| folder.join(reference).exists())
                .map(Path::to_owned)
                .ok_or_else(|| {
                    let problem = format!(
                        "refers to {reference:?}, which is not in a folder above the file; give the folder that contains \
                         it with --data"
                    );
                    ImportError::new(file.display(), "", problem)
                })?,
        };
        let first = Path::new(reference).components().next();
        let own = first.map_or_else(|| root.clone(), |c| root.join(c));
        let own = if own.is_dir() { own } else { root.clone() };
        Ok(Self { root, own, docs: RefCell::default(), parts: OnceCell::new() })
    }

    /// A file to which a value refers, of one of these types.
    pub(crate) fn follow(&self, from: &Node, types: &[&str]) -> Result<Rc<Doc>, ImportError> {
        let path = self.place(from)?;
        self.load(&path, types).map_err(|e| if e.file.is_empty() { from.error(e.problem) } else { e })
    }

    /// The place of a file to which a value refers.
    pub(crate) fn place(&self, from: &Node) -> Result<PathBuf, ImportError> {
        let name = from.text()?;
        if name.contains("..") || Path::new(name).is_absolute() {
            return from.fail(format!("{name:?} leaves the folder of the set; paths are relative to it"));
        }
        let path = self.root.join(name);
        if !path.is_file() {
            let root = self.root.display();
            return from.fail(format!(
                "refers to {name:?}, which is not in {root}; add the file or give another folder with --data"
            ));
        }
        Ok(path)
    }

    /// A file of one of these types.
    pub(crate) fn load(&self, path: &Path, types: &[&str]) -> Result<Rc<Doc>, ImportError> {
        let known = self.docs.borrow().get(path).cloned();
        if let Some(doc) = known {
            return typed(&doc, types).map(|()| doc);
        }
        if self.docs.borrow().len() >= FILES {
            return Err(ImportError::new(path.display(), "", format!("more than {FILES} files in one set")));
        }
        let text = vb_files::read_text(path, MOST).map_err(|e| ImportError::reading(path, &e))?;
        let doc = Doc::parse(self.short(path), &text)?;
        typed(&doc, types)?;
        Ok(self.add(path, doc))
    }

    /// Makes a document a part of the set.
    pub(crate) fn add(&self, path: &Path, mut doc: Doc) -> Rc<Doc> {
        doc.file = self.short(path);
        for key in ["Name", "Template"] {
            if let Some(n) = doc.root().get(key) {
                n.used();
            }
        }
        let doc = Rc::new(doc);
        self.docs.borrow_mut().insert(path.to_owned(), doc.clone());
        doc
    }

    /// The path relative to the root, for messages.
    pub(crate) fn short(&self, path: &Path) -> String {
        let relative = path.strip_prefix(&self.root).unwrap_or(path);
        relative.display().to_string()
    }

    /// Files of a type within the set's own folder, with their templates, by path. Files that cannot be read are none.
    pub(crate) fn find(&self, wanted: &str) -> Vec<(PathBuf, String)> {
        let parts = self.parts.get_or_init(|| self.scan());
        let of_type = parts.iter().filter(|[_, kind, _]| kind == wanted);
        of_type.map(|[path, _, template]| (PathBuf::from(path), template.clone())).collect()
    }

    fn scan(&self) -> Vec<[String; 3]> {
        let mut out = Vec::new();
        let mut folders = vec![(self.own.clone(), 0)];
        let mut seen = 0;
        while let Some((folder, depth)) = folders.pop() {
            let Ok(entries) = std::fs::read_dir(&folder) else { continue };
            for entry in entries.flatten() {
                seen += 1;
                if seen > ENTRIES {
                    break;
                }
                let (path, Ok(file_type)) = (entry.path(), entry.file_type()) else { continue };
                if file_type.is_dir() && depth < DEPTH {
                    folders.push((path, depth + 1));
                } else if file_type.is_file() && path.extension().is_some_and(|e| e == "json") {
                    let Ok(text) = vb_files::read_text(&path, MOST) else { continue };
                    let Ok(doc) = Doc::parse(String::new(), &text) else { continue };
                    if let (Ok(kind), Some(path)) = (kind(&doc), path.to_str()) {
                        out.push([path.to_owned(), kind, template(&doc).unwrap_or_default()]);
                    }
                }
            }
        }
        out.sort();
        out
    }

    /// Adds what nothing has read of any file to the notes, one note per part.
    pub(crate) fn list_unread(&self, notes: &mut Notes) {
        for doc in self.docs.borrow().values() {
            let mut parts: BTreeMap<String, Vec<String>> = BTreeMap::new();
            for path in doc.unread() {
                let (part, key) = path.rsplit_once('/').unwrap_or(("", &path));
                parts.entry(part.to_owned()).or_default().push(key.to_owned());
            }
            for (part, keys) in parts {
                let place = if part.is_empty() { doc.file.clone() } else { format!("{}: {part}", doc.file) };
                notes.dropped(format!("{place}: {}", keys.join(", ")));
            }
        }
    }
}

/// Refuses a file of another type.
fn typed(doc: &Doc, types: &[&str]) -> Result<(), ImportError> {
    let found = kind(doc)?;
    if types.contains(&found.as_str()) {
        return Ok(());
    }
    let wanted = types.join(" or ");
    let problem = format!("{found:?}, but {wanted:?} is expected here; refer to a file of this type");
    Err(ImportError::new(&doc.file, "Type", problem))
}

/// The `Type` of a file.
pub(crate) fn kind(doc: &Doc) -> Result<String, ImportError> {
    match doc.root().get("Type") {
        Some(t) => Ok(t.text()?.to_owned()),
        None => {
            let problem = "\"Type\" is missing; this is not a file of a Chrono vehicle (give the file with \"Type\": \"Vehicle\")";
            Err(ImportError::new(&doc.file, "", problem))
        }
    }
}

/// The `Template` of a file.
pub(crate) fn template(doc: &Doc) -> Result<String, ImportError> {
    Ok(doc.root().need("Template")?.text()?.to_owned())
}
