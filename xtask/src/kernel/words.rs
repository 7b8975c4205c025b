//! Copies of memory in LLVM's text, word by word, and what else the kernels need that Rust can't say.
//!
//! LLVM turns the larger copies of a kernel into loops over bytes, each of which waits for the one before. They become calls of
//! functions that copy words (`words.ll`).

/// The functions that are called.
const FUNCTIONS: &str = include_str!("words.ll");
/// What LLVM copies with single instructions, bytes.
const SMALL: u64 = 128;

/// The module with its copies and fills of memory word by word.
pub(super) fn by_words(module: &str) -> String {
    let mut text = String::with_capacity(module.len() + FUNCTIONS.len());
    // What is defined here mustn't be declared, too.
    let declared = |line: &str| line.starts_with("declare") && line.contains("@vb_slot(");
    for line in module.lines().filter(|line| !declared(line)) {
        match call(line) {
            Some(call) => text.push_str(&call),
            None => text.push_str(line),
        }
        text.push('\n');
    }
    text + FUNCTIONS
}

/// What stands instead of a line that copies or fills much memory.
fn call(line: &str) -> Option<String> {
    let (start, rest) = line.split_once("call void @llvm.mem")?;
    if !start.trim().is_empty() && start.trim() != "tail" {
        return None;
    }
    let (kind, arguments) = rest.split_once('(')?;
    let (function, is_fill) = match kind {
        "cpy.p0.p0.i64" => ("vb_copy", false),
        "move.p0.p0.i64" => ("vb_move", false),
        "set.p0.i64" => ("vb_fill", true),
        _ => return None,
    };
    let (arguments, _) = arguments.rsplit_once(", i1 false)")?;
    let [to, from, size] = split(arguments)?;
    let alignment = if is_fill { alignment(to) } else { alignment(to).min(alignment(from)) };
    let size = value(size);
    if size.parse::<u64>().is_ok_and(|size| is_small(size, alignment)) {
        return None;
    }
    let kind = if is_fill { "i8" } else { "ptr" };
    Some(format!("  call void @{function}(ptr {}, {kind} {}, i64 {size})", value(to), value(from)))
}

/// Whether LLVM copies this many bytes well.
fn is_small(size: u64, alignment: u64) -> bool {
    size < SMALL && alignment >= 8 || size < SMALL / 4 && alignment >= 4 || size <= 8
}

/// The three arguments, at the commas that are in no brackets.
fn split(arguments: &str) -> Option<[&str; 3]> {
    let (mut depth, mut begin, mut parts) = (0, 0, Vec::new());
    for (at, c) in arguments.char_indices() {
        match c {
            '(' => depth += 1,
            ')' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(arguments[begin..at].trim());
                begin = at + 1;
            }
            _ => {}
        }
    }
    parts.push(arguments[begin..].trim());
    parts.try_into().ok()
}

/// An argument without its type and what else is said of it. A value that is computed in place has brackets.
fn value(argument: &str) -> &str {
    if let Some(at) = argument.find("getelementptr") {
        return &argument[at..];
    }
    argument.rsplit(' ').next().unwrap_or(argument)
}

/// What an address is known to be a multiple of.
fn alignment(argument: &str) -> u64 {
    let number = argument.split_once("align ").map_or("1", |(_, rest)| rest.split(' ').next().unwrap_or("1"));
    number.parse().unwrap_or(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_copies_become_calls_and_others_stay() {
        let copy = |size: &str, align: u32| {
            format!(
                "  tail call void @llvm.memcpy.p0.p0.i64(ptr noundef nonnull align {align} dereferenceable(4) %a.b, ptr align \
                 {align} %1, i64 {size}, i1 false), !noalias !2"
            )
        };
        assert_eq!(call(&copy("1032", 8)).unwrap(), "  call void @vb_copy(ptr %a.b, ptr %1, i64 1032)");
        assert_eq!(call(&copy("%n", 8)).unwrap(), "  call void @vb_copy(ptr %a.b, ptr %1, i64 %n)");
        assert!(call(&copy("120", 8)).is_none());
        assert!(call(&copy("120", 4)).is_some());
        assert!(call(&copy("8", 1)).is_none());
        let line = "  call void @llvm.memset.p0.i64(ptr noundef align 8 %110, i8 0, i64 1032, i1 false)";
        assert_eq!(call(line).unwrap(), "  call void @vb_fill(ptr %110, i8 0, i64 1032)");
        let line = "  call void @llvm.memmove.p0.p0.i64(ptr align 8 %2, ptr align 8 getelementptr inbounds nuw (i8, ptr @g, \
                    i64 8), i64 range(i64 0, 9) %n, i1 false)";
        let wanted =
            "  call void @vb_move(ptr %2, ptr getelementptr inbounds nuw (i8, ptr @g, i64 8), i64 %n)";
        assert_eq!(call(line).unwrap(), wanted);
        assert!(
            call("declare void @llvm.memset.p0.i64(ptr writeonly captures(none), i8, i64, i1 immarg) #16")
                .is_none()
        );
    }

    #[test]
    fn a_module_gets_the_functions_that_it_calls() {
        let text = by_words("a\nb\n");
        assert!(text.starts_with("a\nb\n"));
        for function in ["vb_copy", "vb_move", "vb_fill"] {
            assert_eq!(text.matches(&format!("define internal void @{function}(")).count(), 1);
        }
        // LLVM takes no function that is declared and defined.
        let text = by_words("a\ndeclare noundef ptr @vb_slot() unnamed_addr #4\nb\n");
        assert!(text.starts_with("a\nb\n") && text.contains("define internal ptr @vb_slot("));
    }
}
