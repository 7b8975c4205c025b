//! The kernels of `vb-kernel` for a GPU of NVIDIA: the simulator compiled as it is.
//!
//! Rust has a target for these GPUs, without a standard library. Debian's compiler comes with the library's sources, of which a
//! copy is built here for a system that has no threads, no files and no clock. Elementary functions of the platform become those
//! of `libm`, which `vb-kernel` has. Then LLVM makes PTX of it, and NVIDIA's assembler, from PyPI, machine code.

mod words;

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use lzma_rust2::{XzOptions, XzWriter};
use serde_json::{Value, json};

use crate::examples::Compiler;
use crate::run::{Failure, output, run, step};
use crate::{root, target_dir};

/// The kinds of GPUs that kernels are built for: from the A100 on, the H100 and H200, the B200, and the RTX 50. Each file is also for
/// later GPUs of its generation, as that of the A100 is for the RTX 30 and 40.
const ARCHITECTURES: [&str; 4] = ["sm_80", "sm_90", "sm_100", "sm_120"];
/// The assembler and linker. What they make runs with drivers of CUDA 13 on.
const ASSEMBLER: &str = "nvidia-cuda-nvcc==13.5.37";
/// A system of which the standard library knows that it has nothing but memory and an end: RISC Zero's virtual machine.
const SYSTEM: &str = "zkvm";
/// The elementary functions that the standard library asks of the platform: their names there and in C.
const ELEMENTARY: [(&str, &str); 8] = [
    ("sin", "sin"),
    ("cos", "cos"),
    ("exp", "exp"),
    ("exp2", "exp2"),
    ("log", "ln"),
    ("log2", "log2"),
    ("log10", "log10"),
    ("pow", "powf"),
];

/// Builds the kernels of these architectures, by default of all; says where they are.
pub(crate) fn kernel(architectures: &[&str]) -> Result<(), Failure> {
    if let Some(unknown) = architectures.iter().find(|name| !ARCHITECTURES.contains(name)) {
        let known = ARCHITECTURES.join(", ");
        return Err(Failure::new(format!("kernel: `{unknown}` is none of the architectures: {known}")));
    }
    let architectures = if architectures.is_empty() { &ARCHITECTURES } else { architectures };
    let folder = target_dir().join("kernel");
    std::fs::create_dir_all(&folder).map_err(failure(&folder))?;
    let assembler = Compiler::of_pip(ASSEMBLER)?;
    assembler.install()?;
    let tools = assembler.folder.join("nvidia").join("cu13").join("bin");
    let llc = llvm_tool("llc")?;

    let toolchain = toolchain(&folder)?;
    let target = folder.join("nvptx64-std.json");
    let rustc = toolchain.join("rustc-wasm");
    write(&target, &specification(&rustc)?)?;

    step("compiling the simulator for the GPU, which takes some minutes");
    let build = folder.join("build");
    let mut cargo = Command::new(toolchain.join("cargo-wasm"));
    cargo.args(["rustc", "--quiet", "--profile", "kernel", "--package", "vb-kernel", "--lib"]);
    cargo.args(["--crate-type", "cdylib", "-Zjson-target-spec", "-Zpanic-immediate-abort"]);
    cargo.args(["-Zbuild-std=std,panic_abort", "--target"]).arg(&target).arg("--target-dir").arg(&build);
    cargo.args(["--", "--emit", "llvm-ir", "-C", "linker=/bin/true"]);
    cargo.env("RUSTC_BOOTSTRAP", "1").env_remove("CARGO_ENCODED_RUSTFLAGS").current_dir(root());
    cargo.env(
        "RUSTFLAGS",
        "-Zunstable-options -Cpanic=immediate-abort -Zlocation-detail=none -Zfmt-debug=none",
    );
    run(&mut cargo)?;

    let module = build.join("nvptx64-std").join("kernel").join("deps").join("vb_kernel.ll");
    let text = std::fs::read_to_string(&module).map_err(failure(&module))?;
    let by_words = folder.join("vb-kernel.ll");
    write(&by_words, &words::by_words(&text))?;

    for architecture in architectures {
        step(&format!("assembling it for {architecture}, which takes three minutes and 9 GB of memory"));
        let file = assemble(&folder, [&llc, &tools], &by_words, architecture)?;
        step(&format!("the kernels are in {}", file.display()));
    }
    Ok(())
}

/// Makes the file of an architecture's kernels out of the module; returns its path.
fn assemble(
    folder: &Path,
    [llc, tools]: [&PathBuf; 2],
    module: &Path,
    architecture: &str,
) -> Result<PathBuf, Failure> {
    let ptx = folder.join("vb-kernel.ptx");
    let mut compile = Command::new(llc);
    compile.args(["-O3", "-mtriple=nvptx64-nvidia-cuda"]).arg(format!("-mcpu={architecture}"));
    run(compile.arg(module).arg("-o").arg(&ptx))?;
    let text = std::fs::read_to_string(&ptx).map_err(failure(&ptx))?;
    if let Some(line) = text.lines().find(|line| line.contains("fma.rn") || line.contains(".ftz")) {
        return Err(Failure::new(format!(
            "{}: `{}` rounds otherwise than a CPU does, so states would differ",
            ptx.display(),
            line.trim()
        )));
    }
    let (object, code) = (folder.join("vb-kernel.o"), folder.join("vb-kernel.cubin"));
    let mut assemble = Command::new(tools.join("ptxas"));
    run(assemble.arg("-c").arg(format!("-arch={architecture}")).arg(&ptx).arg("-o").arg(&object))?;
    let mut link = Command::new(tools.join("nvlink"));
    link.arg("--suppress-stack-size-warning")
        .arg(format!("-arch={architecture}"))
        .arg(&object)
        .arg("-o")
        .arg(&code);
    run(&mut link)?;

    let file = folder.join(format!("vb-kernel-{architecture}.cubin.xz"));
    let bytes = std::fs::read(&code).map_err(failure(&code))?;
    let packed = pack(&bytes).map_err(failure(&file))?;
    std::fs::write(&file, packed).map_err(failure(&file))?;
    Ok(file)
}

/// Bytes as a file of xz has them.
fn pack(bytes: &[u8]) -> std::io::Result<Vec<u8>> {
    let mut packed = XzWriter::new(Vec::new(), XzOptions::default())?;
    packed.write_all(bytes)?;
    packed.finish()
}

/// Debian's compiler, with the sources of the standard library for GPUs, in this folder.
fn toolchain(folder: &Path) -> Result<PathBuf, Failure> {
    let home = folder.join("rust");
    let script = root().join("xtask/install-wasm-toolchain.sh");
    if output(Command::new("bash").arg(script).env("VB_WASM_HOME", &home)).is_none() {
        return Err(Failure::new(
            "kernels are built by Debian's compiler, which can't be had here: see that `apt-get download rustc-web` works",
        ));
    }
    let toolchain = home.join("toolchain");
    let library = toolchain.join("lib/rustlib/src/rust/library/std/src");
    let change = |file: &str, change: &dyn Fn(String) -> Option<String>| {
        let path = library.join(file);
        let text = std::fs::read_to_string(&path).map_err(failure(&path))?;
        let changed = change(text).ok_or_else(|| {
            Failure::new(format!("{}: not the standard library that can be changed for GPUs", path.display()))
        })?;
        write(&path, &changed)
    };
    change("sys/alloc/mod.rs", &|text| {
        let own = "target_arch = \"nvptx64\", ";
        let place = "target_arch = \"x86_64\",";
        let known = text.contains(own);
        if known {
            Some(text)
        } else {
            text.contains(place).then(|| text.replacen(place, &format!("{own}{place}"), 1))
        }
    })?;
    for (file, bits) in [("num/f64.rs", 64), ("num/f32.rs", 32)] {
        change(file, &|text| with_elementary(text, bits))?;
    }
    Ok(toolchain)
}

/// The standard library's numbers of this many bits, with the functions of C in place of what a platform's are made of.
fn with_elementary(mut text: String, bits: u32) -> Option<String> {
    for (function, method) in ELEMENTARY {
        let (name, kind) = (format!("{function}{}", if bits == 64 { "" } else { "f" }), format!("f{bits}"));
        let (parameters, arguments) = match method {
            "powf" => (format!("x: {kind}, y: {kind}"), "self, n"),
            _ => (format!("x: {kind}"), "self"),
        };
        let intrinsic = format!("intrinsics::{function}{kind}({arguments})");
        let call = format!(
            "unsafe {{ unsafe extern \"C\" {{ fn {name}({parameters}) -> {kind}; }} {name}({arguments}) }}"
        );
        if !text.contains(&call) {
            text = text.contains(&intrinsic).then(|| text.replacen(&intrinsic, &call, 1))?;
        }
    }
    Some(text)
}

/// What the compiler is told of the target.
fn specification(rustc: &Path) -> Result<String, Failure> {
    let mut command = Command::new(rustc);
    command.args(["-Zunstable-options", "--print", "target-spec-json", "--target", "nvptx64-nvidia-cuda"]);
    let text = output(command.env("RUSTC_BOOTSTRAP", "1"));
    let read = text.and_then(|text| serde_json::from_str::<Value>(&text).ok());
    let mut target = read.ok_or_else(|| Failure::new(format!("{} knows no GPUs", rustc.display())))?;
    target["os"] = json!(SYSTEM);
    target["cpu"] = json!(ARCHITECTURES[0]);
    Ok(target.to_string())
}

/// A program of LLVM that rustup installs.
fn llvm_tool(name: &str) -> Result<PathBuf, Failure> {
    let missing = || Failure::new("run `rustup component add llvm-tools`, which has the compiler for GPUs");
    let libraries = output(Command::new("rustc").args(["--print", "target-libdir"])).ok_or_else(missing)?;
    let tool = Path::new(&libraries).with_file_name("bin").join(name);
    if tool.is_file() { Ok(tool) } else { Err(missing()) }
}

fn write(path: &Path, text: &str) -> Result<(), Failure> {
    std::fs::write(path, text).map_err(failure(path))
}

fn failure(path: &Path) -> impl Fn(std::io::Error) -> Failure {
    let path = path.to_owned();
    move |e| Failure::new(format!("{}: {e}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Files that are made and aren't looked for would never be found.
    #[test]
    fn fleets_look_for_the_kernels_of_all_architectures() {
        let looks = include_str!("../../../harness/learn/gpu/src/code.rs");
        let capabilities = ARCHITECTURES.map(|name| {
            let number: u32 = name.trim_start_matches("sm_").parse().unwrap();
            format!("({}, {})", number / 10, number % 10)
        });
        assert!(looks.contains(&format!("= [{}];", capabilities.join(", "))), "{capabilities:?}");
    }

    /// What kernels are made of and their hash leaves out could change without anybody noticing.
    #[test]
    fn the_hash_of_kernels_is_over_all_crates_that_they_are_made_of() {
        let mut cargo = Command::new(env!("CARGO"));
        cargo.args(["tree", "--offline", "--prefix", "none", "--edges", "normal", "--package", "vb-kernel"]);
        let told = output(cargo.current_dir(root())).unwrap();
        let names = told.lines().filter_map(|line| line.strip_prefix("vb-")?.split(' ').next());
        let mut names: Vec<_> = names.collect();
        names.sort_unstable();
        names.dedup();
        let hashed = include_str!("../../../harness/learn/kernel/build.rs");
        let (_, list) = hashed.split_once("const CRATES: ").unwrap();
        let (list, _) = list.split_once("];").unwrap();
        // Folders, of which the last is named as the crate.
        let mut own: Vec<_> = list.split('"').filter_map(|text| Some(text.rsplit_once('/')?.1)).collect();
        own.sort_unstable();
        assert_eq!(own, names);
    }

    #[test]
    fn elementary_functions_are_changed_once() {
        let library: String = ELEMENTARY
            .iter()
            .map(|(c, method)| {
                let arguments = if *method == "powf" { "self, n" } else { "self" };
                format!("pub fn {method}({arguments}) -> f64 {{ intrinsics::{c}f64({arguments}) }}\n")
            })
            .collect();
        let changed = with_elementary(library, 64).unwrap();
        assert!(!changed.contains("intrinsics"), "{changed}");
        assert!(changed.contains(
            "pub fn ln(self) -> f64 { unsafe { unsafe extern \"C\" { fn log(x: f64) -> f64; } log(self) } }"
        ));
        assert_eq!(with_elementary(changed.clone(), 64).unwrap(), changed);
        assert!(with_elementary("other sources".into(), 64).is_none());
    }
}
