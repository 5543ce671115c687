//! Arbitrary input for both decoders and both state machines. `docs/fuzzing.md` says how to run these for
//! longer and where inputs worth keeping go.

#[path = "fuzz/decoding.rs"]
mod decoding;
#[path = "fuzz/machines.rs"]
mod machines;

/// Inputs made up in a run of `cargo test`, beside those of the corpus.
const ITERATIONS: usize = 3000;

#[test]
fn fuzz_decoder() {
    bolero::check!()
        .with_iterations(ITERATIONS)
        .for_each(decoding::decoder);
}

#[test]
fn fuzz_receiver() {
    bolero::check!()
        .with_iterations(ITERATIONS)
        .for_each(decoding::receiver);
}

#[test]
fn fuzz_farm() {
    bolero::check!()
        .with_iterations(ITERATIONS)
        .for_each(machines::farm);
}

#[test]
fn fuzz_fop() {
    bolero::check!()
        .with_iterations(ITERATIONS)
        .for_each(machines::fop);
}
