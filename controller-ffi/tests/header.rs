//! The header is what cbindgen writes.

use std::path::Path;

#[test]
fn the_header_is_what_cbindgen_writes() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config =
        cbindgen::Config::from_file(folder.join("cbindgen.toml")).expect("a sound configuration");
    let mut text = Vec::new();
    cbindgen::Builder::new()
        .with_config(config)
        .with_src(folder.join("src/lib.rs"))
        .generate()
        .expect("a sound source")
        .write(&mut text);
    let text = String::from_utf8(text).expect("text");
    let path = folder.join("include/saltus_controller_ffi.h");
    if std::env::var_os("SALTUS_WRITE_HEADER").is_some() {
        std::fs::write(&path, &text).expect("a place to write");
    }
    let there = std::fs::read_to_string(&path).expect("a header");
    assert!(
        there == text,
        "write it anew: SALTUS_WRITE_HEADER=1 cargo test -p saltus-controller-ffi --test header"
    );
}
