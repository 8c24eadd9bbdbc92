#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Err(failure) = leafwise_fuzz_checks::documents::check(bytes) {
        panic!("{failure}");
    }
});
