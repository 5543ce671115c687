//! Fuzzing of both decoders and both state machines. `docs/fuzzing.md` describes longer runs and the corpus.

mod decoding;
mod machines;

/// Number of generated inputs in a run of `cargo test`, in addition to the corpus.
const ITERATIONS: usize = 2000;

#[test]
fn fuzz_decoder() {
    bolero::check!()
        .with_iterations(ITERATIONS)
        .for_each(|input: &[u8]| {
            decoding::decoder(input);
            decoding::decoder(&decoding::sown(input));
        });
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
        .with_generator(bolero::produce::<Vec<u8>>().with().len(0..1000_usize))
        .for_each(|input: &Vec<u8>| machines::farm(input));
}

#[test]
fn fuzz_fop() {
    bolero::check!()
        .with_iterations(ITERATIONS)
        .with_generator(bolero::produce::<Vec<u8>>().with().len(0..1000_usize))
        .for_each(|input: &Vec<u8>| machines::fop(input));
}
