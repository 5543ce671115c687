//! Puts `memory.x` where the linker looks for it. Options of the linker are here rather than in `.cargo/config.toml`, so that both
//! boards of this chip share the compiled `core`.

use std::env;
use std::fs;
use std::path::Path;

fn main() {
    let out = env::var("OUT_DIR").unwrap_or_default();
    if let Err(error) = fs::copy("memory.x", Path::new(&out).join("memory.x")) {
        println!("cargo::error=memory.x: {error}");
    }
    println!("cargo::rustc-link-search={out}");
    println!("cargo::rustc-link-arg=--nmagic");
    println!("cargo::rustc-link-arg=-Tlink.x");
    println!("cargo::rerun-if-changed=memory.x");
}
