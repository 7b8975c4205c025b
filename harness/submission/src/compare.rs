//! Where two documents differ.

use serde::Serialize;
use serde_json::Value;

/// Differences that are told at most.
const MOST: usize = 20;

/// A leaf in which two documents differ.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Difference {
    /// Dotted path.
    pub(crate) path: String,
    /// The one's value as text.
    pub(crate) a: String,
    /// The other's.
    pub(crate) b: String,
}

/// The leaves in which two values differ as JSON, not more than some.
pub(crate) fn differences<A: Serialize, B: Serialize>(a: &A, b: &B) -> Vec<Difference> {
    let value = |v: Result<Value, serde_json::Error>| v.unwrap_or(Value::Null);
    let mut found = Vec::new();
    walk("", Some(&value(serde_json::to_value(a))), Some(&value(serde_json::to_value(b))), &mut found);
    found
}

fn walk(path: &str, a: Option<&Value>, b: Option<&Value>, found: &mut Vec<Difference>) {
    if found.len() == MOST || a == b {
        return;
    }
    let below = |key: &str| if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
    match (a, b) {
        (Some(Value::Object(a)), Some(Value::Object(b))) => {
            let keys: std::collections::BTreeSet<&String> = a.keys().chain(b.keys()).collect();
            for key in keys {
                walk(&below(key), a.get(key), b.get(key), found);
            }
        }
        (Some(Value::Array(a)), Some(Value::Array(b))) => {
            for k in 0..a.len().max(b.len()) {
                walk(&below(&k.to_string()), a.get(k), b.get(k), found);
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
        let paths: Vec<String> = differences(&a, &b).into_iter().map(|d| d.path).collect();
        assert_eq!(paths, ["only", "y.z.1", "y.z.2"]);
        assert_eq!(differences(&a, &a), []);
        // By the last bit.
        assert_eq!(differences(&json!(0.1), &json!(0.100_000_000_000_000_02)).len(), 1);
    }
}
