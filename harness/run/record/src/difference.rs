//! Where two documents differ.

use serde::Serialize;
use serde_json::Value;

/// A leaf in which two documents differ.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// The place of the leaf: names and indices, joined by dots.
    pub path: String,
    /// The value in the first document as JSON, or `nothing`.
    pub a: String,
    /// The value in the second document as JSON, or `nothing`.
    pub b: String,
}

/// The first `most` leaves in which two values differ as JSON, in the order of their paths.
///
/// # Panics
/// Panics if a value can't be written as JSON; headers, records, rules and their parts can.
#[must_use]
pub fn differences<A: Serialize, B: Serialize>(a: &A, b: &B, most: usize) -> Vec<Difference> {
    const WHY: &str = "the value has text keys and can be written as JSON";
    let (a, b) = (serde_json::to_value(a).expect(WHY), serde_json::to_value(b).expect(WHY));
    let mut found = Vec::new();
    walk("", Some(&a), Some(&b), most, &mut found);
    found
}

fn walk(path: &str, a: Option<&Value>, b: Option<&Value>, most: usize, found: &mut Vec<Difference>) {
    if found.len() == most || a == b {
        return;
    }
    let below = |key: &str| if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
    match (a, b) {
        (Some(Value::Object(a)), Some(Value::Object(b))) => {
            let keys: std::collections::BTreeSet<&String> = a.keys().chain(b.keys()).collect();
            for key in keys {
                walk(&below(key), a.get(key), b.get(key), most, found);
            }
        }
        // Each field of an object that only one has.
        (Some(Value::Object(own)), None) if !own.is_empty() => {
            own.iter().for_each(|(key, value)| walk(&below(key), Some(value), None, most, found));
        }
        (None, Some(Value::Object(own))) if !own.is_empty() => {
            own.iter().for_each(|(key, value)| walk(&below(key), None, Some(value), most, found));
        }
        (Some(Value::Array(a)), Some(Value::Array(b))) => {
            for k in 0..a.len().max(b.len()) {
                walk(&below(&k.to_string()), a.get(k), b.get(k), most, found);
            }
        }
        _ => {
            let text = |v: Option<&Value>| v.map_or_else(|| "nothing".to_owned(), Value::to_string);
            found.push(Difference { path: path.to_owned(), a: text(a), b: text(b) });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn every_leaf_that_differs_is_named() {
        let a = json!({"x": 1, "y": {"z": [1, 2]}, "only": null});
        let b = json!({"x": 1, "y": {"z": [1, 3, 4]}});
        let paths = |most| -> Vec<String> { differences(&a, &b, most).into_iter().map(|d| d.path).collect() };
        assert_eq!(paths(9), ["only", "y.z.1", "y.z.2"]);
        assert_eq!(paths(2), ["only", "y.z.1"]);
        let paths = differences(&json!({"x": {"y": 1}, "z": {}}), &json!({}), 9);
        assert_eq!(paths.into_iter().map(|d| d.path).collect::<Vec<_>>(), ["x.y", "z"]);
        assert_eq!(differences(&a, &a, 9), []);
        // By the last bit.
        assert_eq!(differences(&json!(0.1), &json!(0.100_000_000_000_000_02), 9).len(), 1);
    }
}
