//! Expressions of xacro: the part of Python's that robot descriptions use.

use std::collections::BTreeMap;

/// Depth of nested parts beyond which an expression is refused.
const DEEPEST: usize = 64;

/// A value of a property.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Value {
    Number(f64),
    Text(String),
    Flag(bool),
}

impl Value {
    /// The value of a text as it stands in a file: a number or a truth where it is one.
    pub(crate) fn of(text: &str) -> Self {
        let t = text.trim();
        match t {
            "true" | "True" => Self::Flag(true),
            "false" | "False" => Self::Flag(false),
            _ => t
                .parse()
                .ok()
                .filter(|x: &f64| x.is_finite())
                .map_or_else(|| Self::Text(text.to_owned()), Self::Number),
        }
    }

    pub(crate) fn text(&self) -> String {
        match self {
            Self::Number(x) => x.to_string(),
            Self::Text(t) => t.clone(),
            Self::Flag(f) => if *f { "True" } else { "False" }.to_owned(),
        }
    }

    /// Whether the value counts as true in a condition.
    pub(crate) fn truth(&self) -> Option<bool> {
        match self {
            Self::Flag(f) => Some(*f),
            Self::Number(x) => Some(*x != 0.0),
            Self::Text(t) if t.trim().is_empty() => Some(false),
            Self::Text(_) => None,
        }
    }

    fn number(&self) -> Result<f64, String> {
        match self {
            Self::Number(x) => Ok(*x),
            Self::Flag(f) => Ok(f64::from(u8::from(*f))),
            Self::Text(t) => Err(format!("{t:?} is not a number")),
        }
    }
}

/// Evaluates an expression with these names.
pub(crate) fn evaluate(text: &str, names: &BTreeMap<String, Value>) -> Result<Value, String> {
    let mut p = Parser { tokens: tokens(text)?, at: 0, names, depth: 0 };
    let value = p.choice()?;
    match p.tokens.get(p.at) {
        None => Ok(value),
        Some(t) => Err(format!("{t:?} is not expected")),
    }
}

#[derive(Clone, Debug, PartialEq)]
enum Token {
    Number(f64),
    Text(String),
    Name(String),
    Sign(&'static str),
}

const SIGNS: &[&str] =
    &["**", "//", "==", "!=", "<=", ">=", "+", "-", "*", "/", "%", "(", ")", "<", ">", ","];

fn tokens(text: &str) -> Result<Vec<Token>, String> {
    let mut out = Vec::new();
    let mut rest = text.trim_start();
    while let Some(c) = rest.chars().next() {
        if c.is_ascii_digit() || (c == '.' && rest[1..].starts_with(|d: char| d.is_ascii_digit())) {
            let mut end = rest.len();
            let mut previous = ' ';
            for (i, d) in rest.char_indices() {
                let exponent = matches!(d, '+' | '-') && matches!(previous, 'e' | 'E');
                if !(d.is_ascii_digit() || matches!(d, '.' | 'e' | 'E') || exponent) {
                    end = i;
                    break;
                }
                previous = d;
            }
            let x = rest[..end].parse().map_err(|_| format!("{:?} is not a number", &rest[..end]))?;
            out.push(Token::Number(x));
            rest = &rest[end..];
        } else if c.is_alphabetic() || c == '_' {
            let end =
                rest.find(|d: char| !(d.is_alphanumeric() || d == '_' || d == '.')).unwrap_or(rest.len());
            out.push(Token::Name(rest[..end].to_owned()));
            rest = &rest[end..];
        } else if c == '\'' || c == '"' {
            let end = rest[1..].find(c).ok_or("a text is not terminated")?;
            out.push(Token::Text(rest[1..=end].to_owned()));
            rest = &rest[end + 2..];
        } else {
            let sign = SIGNS
                .iter()
                .find(|s| rest.starts_with(**s))
                .ok_or_else(|| format!("{c:?} is not supported"))?;
            out.push(Token::Sign(sign));
            rest = &rest[sign.len()..];
        }
        rest = rest.trim_start();
    }
    Ok(out)
}

struct Parser<'a> {
    tokens: Vec<Token>,
    at: usize,
    names: &'a BTreeMap<String, Value>,
    depth: usize,
}

impl Parser<'_> {
    fn word(&mut self, word: &str) -> bool {
        let found = matches!(self.tokens.get(self.at), Some(Token::Name(n)) if n == word);
        self.at += usize::from(found);
        found
    }

    fn sign(&mut self, signs: &[&'static str]) -> Option<&'static str> {
        let Some(Token::Sign(s)) = self.tokens.get(self.at) else { return None };
        let found = signs.iter().find(|x| *x == s).copied();
        self.at += usize::from(found.is_some());
        found
    }

    /// `a if condition else b`.
    fn choice(&mut self) -> Result<Value, String> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(format!("nested more than {DEEPEST} levels deep"));
        }
        let value = self.or()?;
        let value = if self.word("if") {
            let condition = self.or()?.truth().ok_or("the condition is neither true nor false")?;
            if !self.word("else") {
                return Err("`if` without `else`".to_owned());
            }
            let other = self.choice()?;
            if condition { value } else { other }
        } else {
            value
        };
        self.depth -= 1;
        Ok(value)
    }

    fn or(&mut self) -> Result<Value, String> {
        let mut left = self.and()?;
        while self.word("or") {
            let right = self.and()?;
            left = if left.truth().unwrap_or(true) { left } else { right };
        }
        Ok(left)
    }

    fn and(&mut self) -> Result<Value, String> {
        let mut left = self.not()?;
        while self.word("and") {
            let right = self.not()?;
            left = if left.truth().unwrap_or(true) { right } else { left };
        }
        Ok(left)
    }

    fn not(&mut self) -> Result<Value, String> {
        let mut times = 0;
        while self.word("not") {
            times += 1;
        }
        let value = self.comparison()?;
        if times == 0 {
            Ok(value)
        } else {
            Ok(Value::Flag(value.truth().unwrap_or(true) == (times % 2 == 0)))
        }
    }

    fn comparison(&mut self) -> Result<Value, String> {
        let left = self.sum()?;
        let Some(sign) = self.sign(&["==", "!=", "<=", ">=", "<", ">"]) else { return Ok(left) };
        let right = self.sum()?;
        let equal = match (&left, &right) {
            (Value::Text(a), Value::Text(b)) => a == b,
            (Value::Text(_), _) | (_, Value::Text(_)) => false,
            _ => left.number()? == right.number()?,
        };
        Ok(Value::Flag(match sign {
            "==" => equal,
            "!=" => !equal,
            "<" => left.number()? < right.number()?,
            ">" => left.number()? > right.number()?,
            "<=" => left.number()? <= right.number()?,
            _ => left.number()? >= right.number()?,
        }))
    }

    fn sum(&mut self) -> Result<Value, String> {
        let mut left = self.product()?;
        while let Some(sign) = self.sign(&["+", "-"]) {
            let right = self.product()?;
            left = match (sign, &left, &right) {
                ("+", Value::Text(a), Value::Text(b)) => Value::Text(format!("{a}{b}")),
                ("+", ..) => Value::Number(left.number()? + right.number()?),
                _ => Value::Number(left.number()? - right.number()?),
            };
        }
        Ok(left)
    }

    fn product(&mut self) -> Result<Value, String> {
        let mut left = self.signed()?;
        while let Some(sign) = self.sign(&["*", "//", "/", "%"]) {
            let (a, b) = (left.number()?, self.signed()?.number()?);
            if b == 0.0 && sign != "*" {
                return Err("division by zero".to_owned());
            }
            left = Value::Number(match sign {
                "*" => a * b,
                "/" => a / b,
                "//" => (a / b).floor(),
                _ => a - b * (a / b).floor(),
            });
        }
        Ok(left)
    }

    fn signed(&mut self) -> Result<Value, String> {
        let mut negative = false;
        while let Some(sign) = self.sign(&["-", "+"]) {
            negative ^= sign == "-";
        }
        let value = self.power()?;
        if negative { Ok(Value::Number(-value.number()?)) } else { Ok(value) }
    }

    fn power(&mut self) -> Result<Value, String> {
        let base = self.atom()?;
        if self.sign(&["**"]).is_none() {
            return Ok(base);
        }
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(format!("nested more than {DEEPEST} levels deep"));
        }
        let exponent = self.signed()?.number()?;
        self.depth -= 1;
        Ok(Value::Number(vb_math::pow(base.number()?, exponent)))
    }

    fn atom(&mut self) -> Result<Value, String> {
        let token = self.tokens.get(self.at).cloned().ok_or("the expression is incomplete")?;
        self.at += 1;
        match token {
            Token::Number(x) => Ok(Value::Number(x)),
            Token::Text(t) => Ok(Value::Text(t)),
            Token::Sign("(") => {
                let value = self.choice()?;
                self.sign(&[")"]).ok_or("a bracket is not closed")?;
                Ok(value)
            }
            Token::Sign(s) => Err(format!("{s:?} is not expected")),
            Token::Name(name) if self.sign(&["("]).is_some() => self.call(&name),
            Token::Name(name) => self.named(&name),
        }
    }

    fn named(&self, name: &str) -> Result<Value, String> {
        if let Some(value) = self.names.get(name) {
            return Ok(value.clone());
        }
        match name.trim_start_matches("math.") {
            "pi" => Ok(Value::Number(std::f64::consts::PI)),
            "True" | "true" => Ok(Value::Flag(true)),
            "False" | "false" => Ok(Value::Flag(false)),
            _ => Err(format!("{name:?} is not defined")),
        }
    }

    fn call(&mut self, name: &str) -> Result<Value, String> {
        let mut given = Vec::new();
        while self.sign(&[")"]).is_none() {
            given.push(self.choice()?);
            if self.sign(&[","]).is_none() {
                self.sign(&[")"]).ok_or("a bracket is not closed")?;
                break;
            }
        }
        let numbers = || given.iter().map(Value::number).collect::<Result<Vec<f64>, String>>();
        let function = name.trim_start_matches("math.");
        if let ("str", [one]) = (function, &given[..]) {
            return Ok(Value::Text(one.text()));
        }
        let x = match (function, &numbers()?[..]) {
            ("sin", [x]) => vb_math::sin_cos(*x).0,
            ("cos", [x]) => vb_math::sin_cos(*x).1,
            ("tan", [x]) => {
                let (s, c) = vb_math::sin_cos(*x);
                s / c
            }
            ("atan2", [y, x]) => vb_math::atan2(*y, *x),
            ("atan", [x]) => vb_math::atan2(*x, 1.0),
            ("sqrt", [x]) if *x >= 0.0 => x.sqrt(),
            ("radians", [x]) => vb_math::angle::radians(*x),
            ("degrees", [x]) => vb_math::angle::degrees(*x),
            ("abs" | "fabs", [x]) => x.abs(),
            ("float", [x]) => *x,
            ("int", [x]) => x.trunc(),
            ("pow", [a, b]) => vb_math::pow(*a, *b),
            ("min", [first, rest @ ..]) => rest.iter().fold(*first, |a, b| a.min(*b)),
            ("max", [first, rest @ ..]) => rest.iter().fold(*first, |a, b| a.max(*b)),
            _ => return Err(format!("the function {name:?} with {} values is not supported", given.len())),
        };
        Ok(Value::Number(x))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arithmetic_texts_and_conditions_follow_pythons_rules() {
        let names: BTreeMap<String, Value> =
            [("r".to_owned(), Value::Number(0.5)), ("side".to_owned(), Value::Text("left".to_owned()))]
                .into();
        let number = |t: &str| evaluate(t, &names).and_then(|v| v.number());
        for (text, expected) in [
            ("2*(r+1)/3", 1.0),
            ("-r**2", -0.25),
            ("2**-1", 0.5),
            ("7 // 2 + 7 % 4", 6.0),
            ("1e-3*1E3", 1.0),
            ("max(r, 2, 1) - min(1, r)", 1.5),
            ("cos(pi) + math.sin(0)", -1.0),
            ("1 if side == 'left' else -1", 1.0),
            ("1 if side != 'left' or not r > 1 and False else -1", -1.0),
        ] {
            assert!((number(text).unwrap() - expected).abs() < 1e-12, "{text}: {:?}", number(text));
        }
        assert_eq!(evaluate("'front_' + side", &names).unwrap(), Value::Text("front_left".to_owned()));
        for (text, says) in [
            ("q + 1", "\"q\" is not defined"),
            ("1/0", "division by zero"),
            ("(1", "not closed"),
            ("load_yaml('x')", "is not a number"),
            ("1 +", "is incomplete"),
            ("[1, 2]", "is not supported"),
        ] {
            let e = evaluate(text, &names).unwrap_err();
            assert!(e.contains(says), "{text}: {e}");
        }
        assert!(evaluate(&"(".repeat(500), &names).unwrap_err().contains("levels deep"));
    }
}
