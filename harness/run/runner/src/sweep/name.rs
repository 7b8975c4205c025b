//! Names of runs, which are names of folders.

use vb_files::sha256;

/// The longest name; file systems allow 255 bytes.
const LONGEST: usize = 150;

/// A name for a folder on every system: what can't be in one becomes `_`, and where something is lost by that, or the name is too
/// long, the beginning of its hash tells it apart.
pub(crate) fn safe(text: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.' | '+' | '=' | ',');
    let name: String = text.chars().map(|c| if plain(c) { c } else { '_' }).take(LONGEST).collect();
    if name == text && !name.starts_with('.') {
        name
    } else {
        format!("_{name}-{}", &sha256(text.as_bytes())[..8])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plain_name_stays_and_others_stay_apart() {
        assert_eq!(safe("pid,speed=5.5--hmmwv--oracle--0"), "pid,speed=5.5--hmmwv--oracle--0");
        let (a, b) = (safe("net,weights=../a/b"), safe("net,weights=../a:b"));
        assert!(a.starts_with("_net,weights=.._a_b-") && a != b, "{a} {b}");
        assert!(!safe("..").starts_with('.') && !safe(".hidden").starts_with('.'));
        let long = safe(&"x".repeat(1000));
        assert!(long.len() < 170 && long != safe(&"x".repeat(1001)));
    }
}
