//! Built-in worlds are valid, and errors in world files are reported with their position.

use sr04_sim::{Outline, OutlineKind, World, WorldError};

/// Parses a world with this plan, followed by `rest`; returns the error's line, column and text.
fn error_in(plan: &str, rest: &str) -> (usize, usize, String) {
    let text = format!("name = \"test\"\ncell_in = 6\nplan = '''\n{plan}\n'''\n{rest}\n");
    match World::parse("test.toml", &text) {
        Err(WorldError::At {
            file,
            line,
            column,
            problem,
        }) => {
            assert_eq!(file, "test.toml");
            (line, column, problem)
        }
        other => panic!("expected an error with a position, got {other:?}"),
    }
}

const ROOM: &str = "########\n#......#\n#..^...#\n#....A.#\n#......#\n########";

#[test]
fn built_in_worlds_are_valid() {
    let names: Vec<&str> = World::built_in_names().collect();
    assert_eq!(
        names,
        [
            "house",
            "living-room",
            "corridor",
            "open-room",
            "stairs",
            "flat",
            "office",
            "dark-room"
        ]
    );
    for name in names {
        let world = World::open(name).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(world.name(), name);
        assert!(!world.about().is_empty());
        assert!(world.outlines().len() >= 4);
    }
    assert_eq!(World::default().name(), "house");
}

#[test]
fn unknown_character_is_reported() {
    let (line, column, problem) = error_in("#####\n#.^.#\n#..?#\n#####", "");
    assert_eq!((line, column), (6, 4));
    assert!(
        problem.contains("'?'") && problem.contains("# wall"),
        "{problem}"
    );
}

#[test]
fn missing_and_second_start_are_reported() {
    let (line, column, problem) = error_in("#####\n#...#\n#####", "");
    assert_eq!((line, column), (3, 8));
    assert!(problem.contains("no start"), "{problem}");
    let (line, column, problem) = error_in("######\n#.^..#\n#..v.#\n######", "");
    assert_eq!((line, column), (6, 4));
    assert!(problem.contains("second start"), "{problem}");
}

#[test]
fn open_floor_is_reported_at_its_position() {
    let (line, column, problem) = error_in("#####\n#.^.#\n#....\n#####", "");
    assert_eq!((line, column), (6, 5));
    assert!(problem.contains("close it with #"), "{problem}");
    let (line, column, problem) = error_in("#####  \n#.^.## \n#....  \n###### ", "");
    assert_eq!((line, column), (6, 6));
    assert!(problem.contains("outside"), "{problem}");
}

#[test]
fn uneven_rows_are_reported() {
    let (line, column, problem) = error_in("#####\n#.^.#\n#...\n#####", "");
    assert_eq!((line, column), (6, 5));
    assert!(
        problem.contains("4 cells") && problem.contains("first row 5"),
        "{problem}"
    );
}

#[test]
fn start_without_room_is_reported() {
    let (line, column, problem) = error_in("#####\n#^..#\n#...#\n#####", "");
    assert_eq!((line, column), (5, 2));
    assert!(problem.contains("6 inches"), "{problem}");
}

#[test]
fn places_outside_the_plan_and_unknown_marks_are_reported() {
    let lamp = |at: &str| format!("[[lamp]]\nname = \"l\"\ncandela = 10\nat = {at}");
    let (line, column, problem) = error_in(ROOM, &lamp("\"Z\""));
    assert_eq!((line, column), (14, 6));
    assert!(problem.contains("no mark Z"), "{problem}");
    let (_, _, problem) = error_in(ROOM, &lamp("[500, 10]"));
    assert!(problem.contains("0 to 48 and 0 to 36 inches"), "{problem}");
    let (_, _, problem) = error_in(ROOM, &lamp("7"));
    assert!(problem.contains("expected a place"), "{problem}");
}

#[test]
fn walker_path_through_a_wall_is_reported() {
    let walker = "[[walker]]\nkind = \"cat\"\npath = [\"A\", [12, 3]]";
    let (line, column, problem) = error_in(ROOM, walker);
    assert_eq!((line, column), (13, 9));
    assert!(problem.contains("blocks the path"), "{problem}");
}

#[test]
fn toml_errors_are_reported() {
    let (line, column, problem) = error_in(ROOM, "colour = 3");
    assert_eq!((line, column), (11, 1));
    assert!(problem.contains("colour"), "{problem}");
    let (line, _, problem) = error_in(ROOM, "[[clutter]]\nkind = \"throne\"\nat = \"A\"");
    assert_eq!(line, 12);
    assert!(problem.contains("throne"), "{problem}");
    let (_, _, problem) = error_in(ROOM, "[[clutter]]\nkind = \"box\"\nat = \"A\"");
    assert!(problem.contains("size_in"), "{problem}");
}

#[test]
fn missing_file_error_lists_the_built_in_worlds() {
    let error = World::open("no/such/world.toml").unwrap_err().to_string();
    assert!(
        error.contains("no/such/world.toml") && error.contains("living-room"),
        "{error}"
    );
}

#[test]
fn plan_is_north_up_and_the_start_is_the_origin() {
    // The robot faces east: the wall to its left, in the north, has negative X.
    let world = World::parse(
        "t",
        "name = \"t\"\ncell_in = 6\nplan = '''\n##########\n#........#\n#...>....#\n#........#\n#........#\n##########\n'''\n",
    )
    .unwrap();
    assert_eq!(world.size_in().map(|side| side as u32), [60, 36]);
    let north = world.outlines().into_iter().any(|outline| match outline {
        Outline::Segment { from, to, .. } => {
            (from.x_in + 9.0).abs() < 1e-6
                && (to.x_in + 9.0).abs() < 1e-6
                && (from.y_in - to.y_in).abs() > 47.9
        }
        Outline::Block { .. } | Outline::Circle { .. } => false,
    });
    assert!(north, "{:?}", world.outlines());
}

#[test]
fn drop_encloses_the_floor_and_its_edge_is_outlined() {
    let world = World::parse(
        "t",
        "name = \"t\"\ncell_in = 6\nplan = '''\n~~~~~~~\n#.....#\n#..^..#\n#.....#\n#######\n'''\n",
    )
    .unwrap();
    let edges = world.outlines().into_iter().filter(|outline| {
        matches!(
            outline,
            Outline::Segment {
                kind: OutlineKind::Edge,
                ..
            }
        )
    });
    assert_eq!(edges.count(), 1);
}

/// The map fills walls: every point inside one is in a block, and no other point is.
#[test]
fn walls_are_filled_and_furniture_is_not() {
    let world = World::parse(
        "t",
        "name = \"t\"\ncell_in = 6\nplan = '''\n#########\n#.....#w#\n#..^....#\n#.......#\n#=======#\n'''\n",
    )
    .unwrap();
    let outlines = world.outlines();
    let is_filled = |x_in: f64, y_in: f64| {
        outlines.iter().any(|outline| match outline {
            Outline::Block { from, to } => {
                let within = |a: f64, b: f64, at: f64| at > a.min(b) && at < a.max(b);
                within(from.x_in, to.x_in, x_in) && within(from.y_in, to.y_in, y_in)
            }
            _ => false,
        })
    };
    // Cells around the start, which is the origin.
    let cells = [
        (0, 0, false),
        (3, 1, true),
        (4, 1, false),
        (0, 2, true),
        (0, -2, true),
    ];
    for (column, row, filled) in cells {
        let (x_in, y_in) = (f64::from(column) * 6.0, f64::from(row) * 6.0);
        assert_eq!(is_filled(x_in, y_in), filled, "{column} {row}");
    }
}

#[test]
fn crowded_houses_have_a_dock_a_drop_and_close_furniture() {
    let again = World::crowded(0);
    assert_eq!(World::crowded(0).outlines(), again.outlines());
    // The reported trials' houses too.
    for seed in (0..5).chain(20_000..20_020) {
        let world = World::crowded(seed);
        assert!(world.reach() > 0.9, "seed {seed}: {}", world.reach());
        let place = world.before_dock(7.0).expect("a crowded house has a dock");
        assert!(world.started_at(place).is_some(), "seed {seed}");
        let mut places = (0..120).flat_map(|x| (0..70).map(move |y| (x, y)));
        assert!(
            places.any(|(x, y)| !world.has_floor(f64::from(x) * 6.0, f64::from(y) * 6.0)),
            "seed {seed} has no drop"
        );
    }
}

/// Number of cells of furniture within 18 in before doorways in the walls that run from west to east.
fn before_doorways(text: &str) -> usize {
    let plan = text.split("'''").nth(1).expect("a plan").trim();
    let rows: Vec<&[u8]> = plan.lines().map(str::as_bytes).collect();
    let is_wall = |row: &[u8]| {
        let (walls, others): (Vec<u8>, Vec<u8>) = row.iter().partition(|&&cell| cell == b'#');
        walls.len() > others.len()
    };
    let mut count = 0;
    for wall in (1..rows.len() - 1).filter(|&row| is_wall(rows[row])) {
        for column in (0..rows[wall].len()).filter(|&column| rows[wall][column] == b'.') {
            let before = (1..=3).flat_map(|by| [wall - by, wall + by]);
            count += before
                .filter(|&row| b"wsk".contains(&rows[row][column]))
                .count();
        }
    }
    count
}

#[test]
fn furniture_stands_before_doorways_of_crowded_houses_alone() {
    let count = |text: fn(u64) -> String| {
        (0..20)
            .map(|seed| before_doorways(&text(seed)))
            .sum::<usize>()
    };
    assert_eq!(count(World::generated_text), 0);
    assert!(
        count(World::crowded_text) > 20,
        "{}",
        count(World::crowded_text)
    );
}

#[test]
fn generated_houses_are_valid_and_repeatable() {
    let mut texts = std::collections::BTreeSet::new();
    for seed in 1..=40 {
        let text = World::generated_text(seed);
        assert_eq!(text, World::generated_text(seed));
        let world = World::generated(seed);
        assert_eq!(world.name(), format!("generated:{seed}"));
        assert!(world.about().contains("rooms"), "seed {seed} has no rooms");
        assert!(world.reach() > 0.95, "seed {seed}: {}", world.reach());
        assert_eq!(
            World::open(world.name()).unwrap().outlines(),
            world.outlines()
        );
        assert!(texts.insert(text), "seed {seed} repeats another house");
    }
    // The first house, on every platform.
    let sum = World::generated_text(1).bytes().fold(0_u32, |sum, byte| {
        sum.wrapping_mul(31).wrapping_add(u32::from(byte))
    });
    assert_eq!(sum, 4_273_781_883);
}

#[test]
fn built_in_worlds_have_no_warnings() {
    for name in World::built_in_names() {
        let world = World::open(name).unwrap();
        assert_eq!(world.warnings(name), Vec::<String>::new());
    }
}

#[test]
fn unreachable_places_are_reported() {
    let row = "#..........#\n";
    let plan = format!(
        "############\n{0}#....^.....#\n{0}{0}####.#######\n{1}#.........A#\n############",
        row,
        row.repeat(9)
    );
    let text = format!(
        "name = \"t\"\ncell_in = 6\nplan = '''\n{plan}\n'''\n\
         [[lamp]]\nname = \"far\"\nat = \"A\"\ncandela = 10\n"
    );
    let world = World::parse("t.toml", &text).unwrap();
    let warnings = world.warnings("t.toml");
    assert_eq!(warnings.len(), 2, "{warnings:?}");
    assert!(
        warnings[0].starts_with("t.toml:11:3: the robot cannot reach"),
        "{warnings:?}"
    );
    assert!(
        warnings[1].starts_with("t.toml:19:11: lamp \"far\""),
        "{warnings:?}"
    );
    assert!(world.reach() < 0.5);
}

#[test]
fn picture_shows_objects_with_a_legend() {
    let picture = World::open("flat").unwrap().picture();
    for line in [
        "  d dock",
        "  ~ no floor",
        "  x black leg or caster",
        "  - cord",
        "  _ sill",
        "  , carpet",
        "  ^ start",
    ] {
        assert_eq!(
            picture.contains(line),
            line != "  ~ no floor",
            "{line}\n{picture}"
        );
    }
    let rows: Vec<&str> = picture.lines().take(44).collect();
    assert!(
        rows.iter().all(|row| row.chars().count() == 60),
        "{picture}"
    );
    assert!(
        World::open("stairs")
            .unwrap()
            .picture()
            .contains("  ~ no floor")
    );
}

#[test]
fn svg_is_complete() {
    for name in World::built_in_names() {
        let svg = World::open(name).unwrap().svg();
        assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>\n"));
        assert!(
            svg.lines()
                .filter(|line| line.starts_with("<polygon"))
                .count()
                > 3
        );
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
    }
}
