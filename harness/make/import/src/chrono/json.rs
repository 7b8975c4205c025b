//! JSON documents whose values are tracked: what nothing has read is listed at the end.

use crate::ImportError;
use serde_json::Value;
use std::cell::RefCell;
use std::collections::BTreeSet;
use vb_vehicle::Point;

/// Depth of a document beyond which it is refused.
const DEEPEST: usize = 32;

/// A file of a set.
#[derive(Debug)]
pub(crate) struct Doc {
    /// Its path as in messages.
    pub(crate) file: String,
    value: Value,
    read: RefCell<BTreeSet<String>>,
}

impl Doc {
    /// Reads JSON with comments, as Chrono's parser accepts it.
    pub(crate) fn parse(file: String, text: &str) -> Result<Self, ImportError> {
        let plain = without_comments(text.trim_start_matches('\u{feff}'));
        let value: Value = serde_json::from_str(&plain).map_err(|e| {
            let problem =
                format!("invalid JSON ({e}); correct the file, or give a JSON file of Project Chrono");
            ImportError::new(&file, format!("line {}", e.line()), problem)
        })?;
        let doc = Self { file, value, read: RefCell::default() };
        if !doc.value.is_object() {
            return Err(ImportError::new(
                &doc.file,
                "",
                "a list or a number, but files of Project Chrono are objects",
            ));
        }
        if depth(&doc.value) > DEEPEST {
            return Err(ImportError::new(&doc.file, "", format!("nested more than {DEEPEST} levels deep")));
        }
        Ok(doc)
    }

    pub(crate) fn root(&self) -> Node<'_> {
        Node { doc: self, value: &self.value, path: String::new() }
    }

    /// Paths of values that were not read; a part of which none was read is listed as a whole.
    pub(crate) fn unread(&self) -> Vec<String> {
        let mut out = Vec::new();
        collect(&self.value, "", &self.read.borrow(), &mut out);
        out
    }
}

fn depth(value: &Value) -> usize {
    match value {
        Value::Object(m) => 1 + m.values().map(depth).max().unwrap_or(0),
        Value::Array(l) => 1 + l.iter().map(depth).max().unwrap_or(0),
        _ => 0,
    }
}

fn join(path: &str, key: &str) -> String {
    if path.is_empty() { key.to_owned() } else { format!("{path}/{key}") }
}

/// Whether a path, something within it, or something around it was read.
fn touched(path: &str, read: &BTreeSet<String>) -> (bool, bool) {
    let whole = read.contains(path);
    let within = ['/', '['].iter().any(|c| {
        let start = format!("{path}{c}");
        read.range(start.clone()..).next().is_some_and(|p| p.starts_with(&start))
    });
    (whole, within)
}

fn collect(value: &Value, path: &str, read: &BTreeSet<String>, out: &mut Vec<String>) {
    let Value::Object(fields) = value else { return };
    for (key, v) in fields {
        let at = join(path, key);
        let (whole, within) = touched(&at, read);
        match (whole, within, v) {
            (true, ..) => {}
            (false, true, Value::Object(_)) => collect(v, &at, read, out),
            (false, true, Value::Array(items)) => {
                for (i, item) in items.iter().enumerate() {
                    collect(item, &format!("{at}[{i}]"), read, out);
                }
            }
            _ => out.push(at),
        }
    }
}

/// The text with comments as spaces, so that lines keep their numbers.
fn without_comments(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut chars = text.chars().peekable();
    let mut string = false;
    while let Some(c) = chars.next() {
        match c {
            '"' => {
                string = !string;
                out.push(c);
            }
            '\\' if string => {
                out.push(c);
                out.extend(chars.next());
            }
            '/' if !string && chars.peek() == Some(&'/') => {
                for c in chars.by_ref() {
                    if c == '\n' {
                        out.push('\n');
                        break;
                    }
                }
            }
            '/' if !string && chars.peek() == Some(&'*') => {
                chars.next();
                let mut last = ' ';
                for c in chars.by_ref() {
                    if c == '\n' {
                        out.push('\n');
                    }
                    if last == '*' && c == '/' {
                        break;
                    }
                    last = c;
                }
            }
            _ => out.push(c),
        }
    }
    out
}

/// A value of a document with its place. Reading it marks it.
#[derive(Clone, Debug)]
pub(crate) struct Node<'a> {
    doc: &'a Doc,
    value: &'a Value,
    path: String,
}

impl<'a> Node<'a> {
    pub(crate) fn fail<T>(&self, problem: impl std::fmt::Display) -> Result<T, ImportError> {
        Err(self.error(problem))
    }

    pub(crate) fn error(&self, problem: impl std::fmt::Display) -> ImportError {
        ImportError::new(&self.doc.file, &self.path, problem)
    }

    pub(crate) fn doc(&self) -> &'a Doc {
        self.doc
    }

    /// The place as in messages.
    pub(crate) fn at(&self) -> String {
        format!("{}: {}", self.doc.file, self.path)
    }

    fn mark(&self) {
        self.doc.read.borrow_mut().insert(self.path.clone());
    }

    /// A field, if it is there.
    pub(crate) fn get(&self, key: &str) -> Option<Node<'a>> {
        let value = self.value.as_object()?.get(key)?;
        Some(Node { doc: self.doc, value, path: join(&self.path, key) })
    }

    /// The first of these fields that is there.
    pub(crate) fn any(&self, keys: &[&str]) -> Option<Node<'a>> {
        keys.iter().find_map(|k| self.get(k))
    }

    /// A field.
    pub(crate) fn need(&self, key: &str) -> Result<Node<'a>, ImportError> {
        self.get(key).ok_or_else(|| self.error(format!("{key:?} is missing; the template needs it")))
    }

    /// All fields with their names.
    pub(crate) fn fields(&self) -> Vec<(&'a str, Node<'a>)> {
        let keys = self.value.as_object().into_iter().flat_map(serde_json::Map::keys);
        keys.filter_map(|k| Some((k.as_str(), self.get(k)?))).collect()
    }

    pub(crate) fn has(&self, key: &str) -> bool {
        self.get(key).is_some()
    }

    /// Marks a value, with all within it, as used.
    pub(crate) fn used(&self) {
        self.mark();
    }

    pub(crate) fn items(&self) -> Result<Vec<Node<'a>>, ImportError> {
        let Value::Array(items) = self.value else { return self.fail("a list is expected") };
        let node = |(i, value)| Node { doc: self.doc, value, path: format!("{}[{i}]", self.path) };
        Ok(items.iter().enumerate().map(node).collect())
    }

    pub(crate) fn number(&self) -> Result<f64, ImportError> {
        self.mark();
        match self.value.as_f64() {
            Some(x) if x.is_finite() => Ok(x),
            _ => self.fail(format!("{} is not a number", vb_files::cut_line(&self.value.to_string(), 60))),
        }
    }

    pub(crate) fn flag(&self) -> Result<bool, ImportError> {
        self.mark();
        self.value.as_bool().ok_or_else(|| self.error("true or false is expected"))
    }

    pub(crate) fn text(&self) -> Result<&'a str, ImportError> {
        self.mark();
        self.value.as_str().ok_or_else(|| self.error("a text is expected"))
    }

    pub(crate) fn numbers(&self) -> Result<Vec<f64>, ImportError> {
        self.mark();
        self.items()?.iter().map(Node::number).collect()
    }

    fn array<const N: usize>(&self) -> Result<[f64; N], ImportError> {
        let numbers = self.numbers()?;
        let found = numbers.len();
        numbers.try_into().or_else(|_| self.fail(format!("{found} numbers, but {N} are expected")))
    }

    pub(crate) fn point(&self) -> Result<Point, ImportError> {
        self.array()
    }

    pub(crate) fn quaternion(&self) -> Result<[f64; 4], ImportError> {
        let q: [f64; 4] = self.array()?;
        if q.iter().map(|x| x * x).sum::<f64>() < 1e-6 {
            return self.fail("a quaternion of length 0 is not an orientation");
        }
        Ok(q)
    }

    /// Pairs of numbers, at least one.
    pub(crate) fn table(&self) -> Result<Vec<[f64; 2]>, ImportError> {
        self.mark();
        let items = self.items()?;
        if items.is_empty() {
            return self.fail("has no points");
        }
        items.iter().map(Node::array).collect()
    }

    /// A number of a field.
    pub(crate) fn num(&self, key: &str) -> Result<f64, ImportError> {
        self.need(key)?.number()
    }

    /// A number of a field that may be absent.
    pub(crate) fn num_or(&self, key: &str, absent: f64) -> Result<f64, ImportError> {
        self.get(key).map_or(Ok(absent), |n| n.number())
    }

    /// A point of a field.
    pub(crate) fn pt(&self, key: &str) -> Result<Point, ImportError> {
        self.need(key)?.point()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_are_no_part_and_unread_values_are_listed() {
        let text = "// head\n{\"A\": {\"x\": 1, \"y\": [1, 2, 3]}, /* no\n */ \"B\": \"// text\", \"C\": [{\"u\": 1}, {\"v\": 2}]}";
        let doc = Doc::parse("f.json".to_owned(), text).unwrap();
        let root = doc.root();
        assert_eq!(root.need("B").unwrap().text().unwrap(), "// text");
        assert_eq!(root.need("A").unwrap().num("x").unwrap(), 1.0);
        root.need("C").unwrap().items().unwrap()[0].num("u").unwrap();
        assert_eq!(doc.unread(), ["A/y", "C[1]/v"]);
        let e = root.need("A").unwrap().pt("z").unwrap_err().to_string();
        assert_eq!(e, "f.json: A: \"z\" is missing; the template needs it");
    }

    #[test]
    fn what_is_no_json_is_named_with_its_line() {
        let e = Doc::parse("f.json".to_owned(), "{\n\"A\": }").unwrap_err().to_string();
        assert!(e.starts_with("f.json: line 2: invalid JSON"), "{e}");
        assert!(Doc::parse("f.json".to_owned(), "[1]").is_err());
        let deep = format!("{{\"a\": {}1{}}}", "[".repeat(60), "]".repeat(60));
        assert!(Doc::parse("f.json".to_owned(), &deep).unwrap_err().to_string().contains("levels deep"));
    }
}
