//! Splits bytes into lines.

/// The runs in `bytes`: each is a line with its line feed and the empty lines after it, so that a flood of line feeds is one run. The last
/// run may be without a line feed.
pub fn runs(mut bytes: &[u8]) -> impl Iterator<Item = &[u8]> {
    std::iter::from_fn(move || {
        let line = line_bytes(bytes);
        let (run, rest) = bytes.split_at(line + empty_lines_bytes(&bytes[line..]));
        bytes = rest;
        (!run.is_empty()).then_some(run)
    })
}

/// Length of the first line with its line feed.
pub(crate) fn line_bytes(bytes: &[u8]) -> usize {
    let line_feed = bytes.iter().position(|&byte| byte == b'\n');
    line_feed.map_or(bytes.len(), |at| at + 1)
}

/// Length of the empty lines at the beginning.
fn empty_lines_bytes(bytes: &[u8]) -> usize {
    let is_end = |byte: &&u8| matches!(byte, b'\r' | b'\n');
    let ends = bytes.iter().take_while(is_end).count();
    let last = bytes[..ends].iter().rposition(|&byte| byte == b'\n');
    last.map_or(0, |at| at + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn empty_lines_stay_with_the_line_before_them() {
        for (bytes, expected) in [
            (&b""[..], &[][..]),
            (b"\n\n\n", &[&b"\n\n\n"[..]]),
            (b"ab\n\r\n\rcd\n\ne", &[b"ab\n\r\n", b"\rcd\n\n", b"e"]),
        ] {
            assert_eq!(runs(bytes).collect::<Vec<_>>(), expected);
        }
    }
}
