//! The picture of the Mega's wiring, docs/mega.svg, from a table of its parts.

use std::fmt::Write as _;
use std::fs;

use crate::root;

/// A part with its wires: the part's name of each, and the board's.
struct Part {
    name: &'static str,
    /// What else it needs.
    notes: &'static [&'static str],
    wires: &'static [(&'static str, &'static str)],
}

const LEFT: &[Part] = &[
    Part {
        name: "Motor driver TB6612FNG",
        notes: &[
            "VM to the battery, VCC and STBY to 5 V",
            "AO1, AO2: left motor; BO1, BO2: right",
            "10 k\u{3a9} from each wire below to ground",
        ],
        wires: &[
            ("PWMA (left)", "D11"),
            ("PWMB (right)", "D12"),
            ("AIN1", "D22"),
            ("AIN2", "D23"),
            ("BIN1", "D24"),
            ("BIN2", "D25"),
        ],
    },
    Part {
        name: "Wheel encoders",
        notes: &["open collector or 5 V"],
        wires: &[("left", "D2"), ("right", "D3")],
    },
    Part {
        name: "Sonars HC-SR04",
        notes: &["5 V"],
        wires: &[
            ("left TRIG", "D26"),
            ("left ECHO", "D49"),
            ("right TRIG", "D27"),
            ("right ECHO", "D48"),
        ],
    },
    Part {
        name: "Bumper and top-hat switches",
        notes: &["each to ground"],
        wires: &[
            ("left", "D47"),
            ("centre", "D46"),
            ("right", "D45"),
            ("top hat", "D44"),
        ],
    },
    Part {
        name: "Edge sensors TCRT5000",
        notes: &[
            "modules with a comparator, 5 V",
            "high without floor; one on each input,",
            "or several behind an OR gate (74HC32)",
        ],
        wires: &[
            ("ahead", "D37"),
            ("ahead left", "D36"),
            ("ahead right", "D35"),
            ("beside left", "D34"),
            ("beside right", "D33"),
            ("behind", "D32"),
            ("behind left", "D31"),
            ("behind right", "D30"),
        ],
    },
];

const RIGHT: &[Part] = &[
    Part {
        name: "Radio HC-12 or USB adapter",
        notes: &["5 V; both modules at 2400 baud"],
        wires: &[("RXD", "D18 (TX1)"), ("TXD", "D19 (RX1)")],
    },
    Part {
        name: "Infrared LEDs",
        notes: &[
            "each with 68 \u{3a9} from 5 V to the collector",
            "of a transistor, emitter to ground",
        ],
        wires: &[("base, 1 k\u{3a9}", "D10")],
    },
    Part {
        name: "Infrared receivers TSSP4038",
        notes: &["5 V through 100 \u{3a9}, 4.7 \u{b5}F to ground"],
        wires: &[("left", "A8"), ("right", "A9")],
    },
    Part {
        name: "Motion detectors HC-SR501",
        notes: &["on the arm, 5 V"],
        wires: &[("left", "A10"), ("right", "A11")],
    },
    Part {
        name: "Dock",
        notes: &["contacts: 20 k\u{3a9} and 10 k\u{3a9} to ground"],
        wires: &[
            ("beacon left", "A12"),
            ("beacon right", "A13"),
            ("contacts", "A14"),
        ],
    },
    Part {
        name: "Photocells",
        notes: &["each to ground, 10 k\u{3a9} to 5 V"],
        wires: &[("left", "A0"), ("right", "A1")],
    },
    Part {
        name: "Battery 12 V",
        notes: &["20 k\u{3a9}, and 10 k\u{3a9} to ground"],
        wires: &[("divider", "A2")],
    },
    Part {
        name: "Arm's servo, beeper",
        notes: &["the servo's 5 V from the regulator"],
        wires: &[("servo", "D5"), ("beeper", "D4")],
    },
    Part {
        name: "Display HD44780 (optional)",
        notes: &[
            "5 V; R/W to ground",
            "V0: middle of a 10 k\u{3a9} trimmer, contrast",
        ],
        wires: &[
            ("RS", "D17"),
            ("E", "D16"),
            ("D4", "D6"),
            ("D5", "D7"),
            ("D6", "D8"),
            ("D7", "D9"),
        ],
    },
];

const ROW: u32 = 18;
const GAP: u32 = 14;
const TOP: u32 = 20;
const WIDTH: u32 = 900;
/// Edges of the parts and of the board.
const PARTS: [u32; 2] = [290, 610];
const BOARD: [u32; 2] = [380, 520];

fn rows(part: &Part) -> u32 {
    1 + part.notes.len() as u32 + part.wires.len() as u32
}

fn height(parts: &[Part]) -> u32 {
    parts.iter().map(|part| rows(part) * ROW + GAP + 8).sum()
}

/// The picture.
fn picture() -> String {
    let bottom = TOP + height(LEFT).max(height(RIGHT));
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {}\" font-family=\"sans-serif\" font-size=\"13\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n\
         <rect x=\"{}\" y=\"{TOP}\" width=\"{}\" height=\"{}\" rx=\"8\" fill=\"#d9ecef\" stroke=\"#1f6f7a\"/>\n\
         <text transform=\"translate(454 {}) rotate(-90)\" text-anchor=\"middle\" font-weight=\"bold\">Arduino Mega 2560</text>\n",
        bottom + 50,
        BOARD[0],
        BOARD[1] - BOARD[0],
        bottom - TOP,
        bottom / 2,
    );
    draw(&mut svg, LEFT, false);
    draw(&mut svg, RIGHT, true);
    // Writing to a string cannot fail.
    let _ = writeln!(
        svg,
        "<text x=\"450\" y=\"{}\" text-anchor=\"middle\">All parts share ground. 5 V from a regulator, not from the Mega: motors and servo take more than it gives.</text>\n</svg>",
        bottom + 30
    );
    svg
}

fn draw(svg: &mut String, parts: &[Part], is_right: bool) {
    let side = usize::from(is_right);
    let (edge, board) = (PARTS[side], BOARD[side]);
    let (left, inner, wire_anchor) = if is_right {
        (edge, edge + 10, "start")
    } else {
        (10, edge - 10, "end")
    };
    let (pin, pin_anchor) = if is_right {
        (board - 6, "end")
    } else {
        (board + 6, "start")
    };
    let mut y = TOP;
    for part in parts {
        let rows = rows(part);
        let _ = writeln!(
            svg,
            "<rect x=\"{left}\" y=\"{y}\" width=\"280\" height=\"{}\" rx=\"6\" fill=\"#f6f2e6\" stroke=\"#8a7a45\"/>",
            rows * ROW + 8
        );
        let mut line = y + ROW - 2;
        let _ = writeln!(
            svg,
            "<text x=\"{}\" y=\"{line}\" font-weight=\"bold\">{}</text>",
            left + 10,
            part.name
        );
        for note in part.notes {
            line += ROW;
            let _ = writeln!(
                svg,
                "<text x=\"{}\" y=\"{line}\" fill=\"#555555\">{}</text>",
                left + 10,
                note
            );
        }
        for (name, at) in part.wires {
            line += ROW;
            let wire = line - 4;
            let _ = writeln!(
                svg,
                "<line x1=\"{edge}\" y1=\"{wire}\" x2=\"{board}\" y2=\"{wire}\" stroke=\"#1f6f7a\" stroke-width=\"1.5\"/>\n\
                 <text x=\"{inner}\" y=\"{line}\" text-anchor=\"{wire_anchor}\">{name}</text>\n\
                 <text x=\"{pin}\" y=\"{line}\" text-anchor=\"{pin_anchor}\">{at}</text>",
            );
        }
        y += rows * ROW + 8 + GAP;
    }
}

/// Writes docs/mega.svg.
pub(crate) fn write() -> Result<(), String> {
    let path = root().join("docs/mega.svg");
    fs::write(&path, picture()).map_err(|error| format!("{}: {error}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn the_picture_in_the_documents_is_the_tables() {
        let path = root().join("docs/mega.svg");
        let drawn = fs::read_to_string(path).unwrap();
        assert!(drawn == picture(), "`cargo xtask wiring` draws it anew");
    }

    #[test]
    fn no_pin_has_two_wires() {
        let mut pins = BTreeSet::new();
        for part in LEFT.iter().chain(RIGHT) {
            for (_, pin) in part.wires {
                assert!(pins.insert(pin), "{pin}");
            }
        }
    }
}
