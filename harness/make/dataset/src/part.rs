//! The parts that a dataset is split into.

use crate::error::DatasetError;

/// Characters of a name at most.
const LENGTH: usize = 100;
/// How far the fractions may be from one whole: thirds are written as 0.33.
const SLACK: f64 = 0.011;

/// A part of a dataset: its name, and its fraction of the worlds.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// The name, which is that of its folder.
    pub name: String,
    /// The fraction, between 0 and 1.
    pub fraction: f64,
}

impl Part {
    /// Refuses parts that are no split of a whole: with names that are no names of folders or are there twice, or with fractions
    /// that don't sum to 1.
    pub(crate) fn check(parts: &[Self]) -> Result<(), DatasetError> {
        let refuse = |problem: String| Err(DatasetError::Parts { problem });
        for (k, Self { name, fraction }) in parts.iter().enumerate() {
            let plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
            if name.is_empty() || name.len() > LENGTH || !name.chars().all(plain) {
                return refuse(format!(
                    "{name:?} is not a valid name (1 to {LENGTH} letters, digits, - and _)"
                ));
            }
            // Not all file systems tell capital letters from small ones.
            if let Some(other) = parts[..k].iter().find(|p| p.name.eq_ignore_ascii_case(name)) {
                return refuse(format!("{} and {name} have the same folder", other.name));
            }
            if !(*fraction > 0.0 && *fraction <= 1.0) {
                return refuse(format!("{name}={fraction} must be above 0 and at most 1"));
            }
        }
        // A sum of nothing is a negative zero.
        let sum = parts.iter().fold(0.0, |sum, p| sum + p.fraction);
        if (sum - 1.0).abs() > SLACK {
            return refuse(format!("the fractions sum to {sum:.3}, not 1"));
        }
        Ok(())
    }

    /// The worlds of each part, in order: at least one if there are as many worlds as parts.
    pub(crate) fn deal<'w, 's>(parts: &[Self], worlds: &'w [&'s str]) -> Vec<&'w [&'s str]> {
        let whole: f64 = parts.iter().map(|p| p.fraction).sum();
        let (mut from, mut sum) = (0, 0.0);
        let share = |part: &Self| {
            sum += part.fraction;
            let to = (worlds.len() as f64 * sum / whole).round() as usize;
            let own = to - from;
            from = to;
            own
        };
        let mut counts: Vec<usize> = parts.iter().map(share).collect();
        // What rounding leaves without a world takes one from the largest.
        for k in 0..counts.len() {
            let largest = (0..counts.len()).max_by_key(|k| counts[*k]).unwrap_or(k);
            if counts[k] == 0 && counts[largest] > 1 && worlds.len() >= parts.len() {
                counts[k] += 1;
                counts[largest] -= 1;
            }
        }
        let mut rest = worlds;
        counts
            .into_iter()
            .map(|count| {
                let (own, others) = rest.split_at(count);
                rest = others;
                own
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parts(of: &[(&str, f64)]) -> Vec<Part> {
        of.iter().map(|(name, fraction)| Part { name: (*name).into(), fraction: *fraction }).collect()
    }

    #[test]
    fn parts_that_are_no_split_of_a_whole_are_refused() {
        for fine in
            [&[("a", 1.0)][..], &[("a", 0.33), ("b", 0.33), ("c", 0.33)], &[("x-1", 0.8), ("x_1", 0.2)]]
        {
            Part::check(&parts(fine)).unwrap();
        }
        let long = "a".repeat(101);
        for (wrong, why) in [
            (&[("", 1.0)][..], "is not a valid name"),
            (&[("..", 1.0)], "is not a valid name"),
            (&[("a/b", 1.0)], "is not a valid name"),
            (&[(&long, 1.0)], "is not a valid name"),
            (&[("a", 0.5), ("a", 0.5)], "a and a have the same folder"),
            (&[("Test", 0.5), ("test", 0.5)], "Test and test have the same folder"),
            (&[("a", 80.0), ("b", 20.0)], "a=80 must be"),
            (&[("a", 0.0), ("b", 1.0)], "a=0 must be"),
            (&[("a", f64::NAN)], "must be above 0"),
            (&[("a", 0.8), ("b", 0.1)], "sum to 0.900"),
            (&[("a", 0.8), ("b", 0.3)], "sum to 1.100"),
            (&[], "sum to 0.000"),
        ] {
            let e = Part::check(&parts(wrong)).unwrap_err().to_string();
            assert!(e.contains(why), "{e}");
        }
    }

    #[test]
    fn every_world_is_dealt_once() {
        let worlds = ["1", "2", "3", "4", "5", "6", "7"];
        let dealt = Part::deal(&parts(&[("a", 0.33), ("b", 0.33), ("c", 0.33)]), &worlds);
        assert_eq!(dealt.concat(), worlds);
        assert_eq!(dealt.iter().map(|own| own.len()).collect::<Vec<_>>(), [2, 3, 2]);
        // A tenth of three or four worlds is none, but a part needs one.
        let usual = parts(&[("train", 0.8), ("validation", 0.1), ("test", 0.1)]);
        for (worlds, counts) in
            [(&worlds[..3], [1, 1, 1]), (&worlds[..4], [2, 1, 1]), (&worlds[..2], [2, 0, 0])]
        {
            let dealt = Part::deal(&usual, worlds);
            assert_eq!(dealt.concat(), worlds);
            assert_eq!(dealt.iter().map(|own| own.len()).collect::<Vec<_>>(), counts);
        }
    }
}
