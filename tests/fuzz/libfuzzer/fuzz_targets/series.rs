#![no_main]
libfuzzer_sys::fuzz_target!(|data: &[u8]| (vb_fuzz::target("series").run)(data));
