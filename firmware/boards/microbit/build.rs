//! Options of the linker: here rather than in `.cargo/config.toml`, so that both boards of this chip share the compiled `core`.

fn main() {
    println!("cargo::rustc-link-arg=-Tmemory.ld");
    println!("cargo::rerun-if-changed=memory.ld");
}
