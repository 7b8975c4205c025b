//! The C header against the structs that the worker uses. Skipped where there is no C compiler.

#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "a helper of a test may fail it")]

use std::mem::{offset_of, size_of};
use std::path::{Path, PathBuf};
use std::process::Command;

use vb_sdk::c::*;

fn header_dir() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../sdk/c")
}

/// The output of a C program, or none where there is no compiler.
fn c_program(body: &str, compiler: &str, extension: &str) -> Option<String> {
    let dir = tempfile::tempdir().unwrap();
    let (source, program) = (dir.path().join(format!("p.{extension}")), dir.path().join("p"));
    let text = format!(
        "#include <stdio.h>\n#include \"vb_planner.h\"\n\
         VB_PLANNER_METADATA(\"p\", \"1\", \"a\", \"b\", \"0.1\", VB_PARAM(\"k\", \"1\", \"h\") \
         VB_NEED(\"lidar 10\") VB_NEED_WITHOUT_MAPS(\"local-map\") VB_MODEL(\"weights 00ff\"));\n\
         int main(void) {{\n{body}\nreturn 0; }}\n"
    );
    std::fs::write(&source, text).unwrap();
    let mut command = Command::new(compiler);
    command.args(["-Wall", "-Wextra", "-Wpedantic", "-Werror", "-I"]).arg(header_dir());
    let built = command.arg("-o").arg(&program).arg(&source).output();
    let Ok(built) = built else {
        vb_testing::skip(format_args!("there is no `{compiler}`"));
        return None;
    };
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    Some(String::from_utf8(Command::new(program).output().unwrap().stdout).unwrap())
}

#[test]
fn structs_have_the_sizes_and_offsets_of_the_c_compiler() {
    let mut body = String::new();
    let mut expected = String::new();
    macro_rules! same {
        ($c:literal, $rust:ty: $($field:ident),*) => {
            body += &format!("printf(\"%s %zu\\n\", \"{0}\", sizeof({0}));\n", $c);
            expected += &format!("{} {}\n", $c, size_of::<$rust>());
            $(
                body += &format!("printf(\"%s %zu\\n\", \"{0}.{1}\", offsetof({0}, {1}));\n", $c, stringify!($field));
                expected += &format!("{}.{} {}\n", $c, stringify!($field), offset_of!($rust, $field));
            )*
        };
    }
    include!("c_header_fields.in");
    same!("vb_error", CError: message);
    same!("vb_host", CHost: context, log);
    same!("vb_planner_functions", CFunctions: size, abi_major, abi_minor, init, step, free);
    if let Some(found) = c_program(&body, "cc", "c") {
        assert_eq!(found, expected);
    }
}

#[test]
fn constants_agree_and_the_header_compiles_as_c_and_cpp_without_a_warning() {
    let body =
        "printf(\"%d %d %d %d %d\\n\", VB_ABI_MAJOR, VB_ABI_MINOR, VB_ERROR_BYTES, VB_FAILED, VB_PANICKED);";
    let expected = format!("{} {} {ERROR_BYTES} {FAILED} {PANICKED}\n", ABI.0, ABI.1);
    assert_eq!(format!("{}.{}", ABI.0, ABI.1), vb_sdk::ABI_VERSION);
    for (compiler, extension) in [("cc", "c"), ("c++", "cpp")] {
        if let Some(found) = c_program(body, compiler, extension) {
            assert_eq!(found, expected, "{compiler}");
        }
    }
}

#[test]
fn the_metadata_macro_writes_what_the_harness_reads() {
    let body = "fwrite(vb_planner_metadata, 1, sizeof vb_planner_metadata - 1, stdout);";
    if let Some(text) = c_program(body, "cc", "c") {
        let metadata = vb_sdk::metadata::Metadata::parse(text.as_bytes()).unwrap();
        assert_eq!((metadata.name.as_str(), metadata.abi.as_str()), ("p", vb_sdk::ABI_VERSION));
        assert_eq!((metadata.control_period, metadata.params[0].key.as_str()), (0.1, "k"));
        let texts =
            |needs: &[vb_sdk::metadata::Need]| needs.iter().map(ToString::to_string).collect::<Vec<_>>();
        assert_eq!(texts(&metadata.needs), ["lidar 10"]);
        assert_eq!(texts(&metadata.needs_without_maps), ["local-map"]);
        assert_eq!(metadata.models, ["weights 00ff"]);
    }
}
