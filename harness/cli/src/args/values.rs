//! Values of options, as people write them.

use clap::builder::{PathBufValueParser, TypedValueParser};
use vb_record::{LogMode, SOIL_RESOLUTIONS, TraceMode};
use vb_vehicle::SCALES;
use vb_world::{Shard, ShardError};

/// A planner: a file, which may lie in the directory that `VB_PLUGINS` names, or a command.
pub(crate) fn planner() -> impl TypedValueParser {
    PathBufValueParser::new().map(crate::places::plugin)
}

/// A number above 0.
pub(crate) fn positive(text: &str) -> Result<f64, String> {
    let value = text.trim().parse::<f64>().ok().filter(|v| v.is_finite() && *v > 0.0);
    value.ok_or_else(|| "want a number above 0".into())
}

/// Columns and rows of pixels.
#[cfg(feature = "replay")]
pub(crate) fn frame_size(text: &str) -> Result<[u32; 2], String> {
    let side = |t: &str| t.parse::<u32>().ok().filter(|n| (64..=vb_render::Size::MAX).contains(n));
    let sides = text.split_once(['x', 'X', '×']).and_then(|(w, h)| side(w).zip(side(h)));
    let wanted = || format!("want columns and rows of 64 to {} pixels, e.g. 1280x720", vb_render::Size::MAX);
    sides.map(|(w, h)| [w, h]).ok_or_else(wanted)
}

/// Widths of figures in a column and across the page, inches; one for both where a page has one column.
pub(crate) fn figure_width(text: &str) -> Result<[f64; 2], String> {
    let number = |t: &str| positive(t).ok().filter(|v| *v <= 40.0);
    let (column, page) = text.split_once(',').unwrap_or((text, text));
    number(column).zip(number(page)).map(|(column, page)| [column, page]).ok_or_else(|| {
        "want inches up to 40, for a column and for the page, e.g. 3.5,7.16, or one for both, e.g. 5.5".into()
    })
}

pub(crate) fn key_value(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((key, value)) if !key.is_empty() => Ok((key.to_owned(), value.to_owned())),
        _ => Err("want KEY=VALUE, e.g. speed=5".into()),
    }
}

/// A shard by its number, or the one that a scheduler's environment says.
pub(crate) fn shard(text: &str) -> Result<Shard, ShardError> {
    if text == "auto" {
        return Shard::from_environment(|name| std::env::var(name).ok());
    }
    Shard::parse(text)
}

pub(crate) fn trace_mode(text: &str) -> Result<TraceMode, String> {
    [TraceMode::None, TraceMode::TenHz, TraceMode::Full]
        .into_iter()
        .find(|mode| mode.name() == text)
        .ok_or_else(|| "want none, 10hz or full".into())
}

pub(crate) fn log_mode(text: &str) -> Result<LogMode, String> {
    LogMode::ALL.into_iter().find(|mode| mode.name() == text).ok_or_else(|| "want all, failed or none".into())
}

/// A number or a fraction.
pub(crate) fn scale(text: &str) -> Result<f64, String> {
    let number = |s: &str| s.trim().parse::<f64>().ok();
    let value = match text.split_once('/') {
        Some((a, b)) => number(a).zip(number(b)).map(|(a, b)| a / b),
        None => number(text),
    };
    value
        .filter(|v| SCALES.contains(v))
        .ok_or_else(|| "want a number or a fraction from 1/100 to 10, e.g. 1, 1/6 or 1/10".into())
}

/// A time in seconds, or with the unit `ms`, `s`, `min` or `h`; returns seconds.
fn seconds(text: &str) -> Option<f64> {
    let text = text.trim();
    let digits = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let number = digits.trim_end().parse::<f64>().ok().filter(|v| v.is_finite())?;
    match &text[digits.len()..] {
        "" | "s" => Some(number),
        "ms" => Some(number / 1000.0),
        "min" => Some(number * 60.0),
        "h" => Some(number * 3600.0),
        _ => None,
    }
}

/// How times are written, for messages.
#[cfg(any(feature = "replay", feature = "ros", feature = "vehicle"))]
const TIMES: &str = "in seconds or with a unit, e.g. 8, 0.5s, 5ms, 2min or 10h";

/// A moment: a time that isn't below 0, s.
#[cfg(feature = "replay")]
pub(crate) fn moment(text: &str) -> Result<f64, String> {
    seconds(text).filter(|v| *v >= 0.0).ok_or_else(|| format!("want a time that is not below 0, {TIMES}"))
}

/// A duration: a time above 0, s.
#[cfg(any(feature = "dataset", feature = "ros", feature = "vehicle"))]
pub(crate) fn duration(text: &str) -> Result<f64, String> {
    seconds(text).filter(|v| *v > 0.0).ok_or_else(|| format!("want a time above 0, {TIMES}"))
}

/// A step of the simulation, of which a whole number makes the time between two samples, s.
pub(crate) fn time_step(text: &str) -> Result<f64, String> {
    seconds(text).filter(|v| vb_trial::is_time_step(*v)).ok_or_else(|| {
        "want a time from 0.1ms to 5ms that divides 10ms, e.g. 0.5ms or 0.0005 (seconds)".into()
    })
}

/// A length in metres that a soil's memory can have.
pub(crate) fn soil_resolution(text: &str) -> Result<f64, String> {
    let value = text.trim().parse::<f64>().ok();
    value
        .filter(|v| SOIL_RESOLUTIONS.contains(v))
        .ok_or_else(|| "want metres from 0.01 to 0.5, e.g. 0.05".into())
}

/// A number of bytes with an optional binary suffix.
pub(crate) fn bytes(text: &str) -> Result<u64, String> {
    let (digits, shift) = match text.chars().last() {
        Some('K' | 'k') => (&text[..text.len() - 1], 10),
        Some('M' | 'm') => (&text[..text.len() - 1], 20),
        Some('G' | 'g') => (&text[..text.len() - 1], 30),
        _ => (text, 0),
    };
    digits
        .parse::<u64>()
        .ok()
        .and_then(|n| n.checked_mul(1 << shift))
        .filter(|n| *n > 0)
        .ok_or_else(|| "want a number of bytes, e.g. 268435456 or 256M".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_read_as_people_write_them() {
        assert_eq!((scale("1"), scale("1/10"), scale("0.25")), (Ok(1.0), Ok(0.1), Ok(0.25)));
        assert!(
            scale("1/0").is_err() && scale("-1").is_err() && scale("nan").is_err() && scale("big").is_err()
        );
        assert_eq!((bytes("4096"), bytes("256M"), bytes("1g")), (Ok(4096), Ok(256 << 20), Ok(1 << 30)));
        assert!(bytes("").is_err() && bytes("M").is_err() && bytes("-1").is_err());
        assert!(
            bytes("99999999999999999999G").is_err()
                && bytes("18446744073709551615K").is_err()
                && bytes("é").is_err()
        );
        assert_eq!(key_value("a=b=c"), Ok(("a".into(), "b=c".into())));
        assert!(key_value("a").is_err() && key_value("=b").is_err());
        assert!(positive("0").is_err() && positive("inf").is_err() && positive("0.5") == Ok(0.5));
        assert_eq!((time_step("0.5ms"), time_step("0.002")), (Ok(0.0005), Ok(0.002)));
        assert!(time_step("1").is_err() && time_step("3ms").is_err() && time_step("0").is_err());
        assert_eq!(trace_mode("10hz"), Ok(TraceMode::TenHz));
        assert!(trace_mode("20hz").is_err());
        assert_eq!(log_mode("all"), Ok(LogMode::All));
        assert!(log_mode("some").is_err());
    }

    #[test]
    fn times_are_seconds_or_have_a_unit() {
        for (text, wanted) in [
            ("8", 8.0),
            ("0.5s", 0.5),
            ("5ms", 0.005),
            ("1 s", 1.0),
            ("0.5min", 30.0),
            ("10h", 36_000.0),
            ("1e3ms", 1.0),
        ] {
            assert_eq!(duration(text), Ok(wanted), "{text}");
        }
        for text in ["", "s", "-1", "0", "5 m", "5sec", "5MS", "inf", "nan", "1s2ms", "0ms"] {
            let e = duration(text).unwrap_err();
            assert!(e.starts_with("want a time above 0, in seconds or with a unit"), "{text}: {e}");
        }
        assert_eq!((moment("0"), moment("2ms")), (Ok(0.0), Ok(0.002)));
        assert!(moment("-1ms").is_err());
    }
}
