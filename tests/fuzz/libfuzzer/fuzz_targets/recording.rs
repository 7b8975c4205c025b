#![no_main]
libfuzzer_sys::fuzz_target!(|data: &[u8]| (vb_fuzz::target("recording").run)(data));
