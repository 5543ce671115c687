//! Worlds that come with the program are sound, and mistakes in others are named.

use sr04_sim::{Outline, OutlineKind, World, WorldError};

/// Parses a world with this plan and these lines behind it; returns its error's line, column, text.
fn mistake(plan: &str, rest: &str) -> (usize, usize, String) {
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
        other => panic!("expected a mistake with a place, got {other:?}"),
    }
}

const ROOM: &str = "########\n#......#\n#..^...#\n#....A.#\n#......#\n########";

#[test]
fn every_built_in_world_is_sound() {
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
fn a_character_without_a_meaning_is_named() {
    let (line, column, problem) = mistake("#####\n#.^.#\n#..?#\n#####", "");
    assert_eq!((line, column), (6, 4));
    assert!(
        problem.contains("'?'") && problem.contains("# wall"),
        "{problem}"
    );
}

#[test]
fn a_missing_and_a_second_start_are_named() {
    let (line, column, problem) = mistake("#####\n#...#\n#####", "");
    assert_eq!((line, column), (3, 8));
    assert!(problem.contains("no start"), "{problem}");
    let (line, column, problem) = mistake("######\n#.^..#\n#..v.#\n######", "");
    assert_eq!((line, column), (6, 4));
    assert!(problem.contains("second start"), "{problem}");
}

#[test]
fn a_leak_is_named_where_it_is() {
    let (line, column, problem) = mistake("#####\n#.^.#\n#....\n#####", "");
    assert_eq!((line, column), (6, 5));
    assert!(problem.contains("close the edge"), "{problem}");
    let (line, column, problem) = mistake("#####  \n#.^.## \n#....  \n###### ", "");
    assert_eq!((line, column), (6, 6));
    assert!(problem.contains("outside"), "{problem}");
}

#[test]
fn ragged_rows_are_named() {
    let (line, column, problem) = mistake("#####\n#.^.#\n#...\n#####", "");
    assert_eq!((line, column), (6, 5));
    assert!(
        problem.contains("4 cells") && problem.contains("first row 5"),
        "{problem}"
    );
}

#[test]
fn a_start_that_is_too_tight_is_named() {
    let (line, column, problem) = mistake("#####\n#^..#\n#...#\n#####", "");
    assert_eq!((line, column), (5, 2));
    assert!(problem.contains("6 inches"), "{problem}");
}

#[test]
fn places_off_the_plan_and_unknown_marks_are_named() {
    let lamp = |at: &str| format!("[[lamp]]\nname = \"l\"\ncandela = 10\nat = {at}");
    let (line, column, problem) = mistake(ROOM, &lamp("\"Z\""));
    assert_eq!((line, column), (14, 6));
    assert!(problem.contains("no mark Z"), "{problem}");
    let (_, _, problem) = mistake(ROOM, &lamp("[500, 10]"));
    assert!(problem.contains("48 by 36 inches"), "{problem}");
    let (_, _, problem) = mistake(ROOM, &lamp("7"));
    assert!(problem.contains("a place is"), "{problem}");
}

#[test]
fn a_path_through_a_wall_is_named() {
    let walker = "[[walker]]\nkind = \"cat\"\npath = [\"A\", [12, 3]]";
    let (line, column, problem) = mistake(ROOM, walker);
    assert_eq!((line, column), (13, 9));
    assert!(problem.contains("meets something"), "{problem}");
}

#[test]
fn mistakes_of_toml_are_named() {
    let (line, column, problem) = mistake(ROOM, "colour = 3");
    assert_eq!((line, column), (11, 1));
    assert!(problem.contains("colour"), "{problem}");
    let (line, _, problem) = mistake(ROOM, "[[clutter]]\nkind = \"throne\"\nat = \"A\"");
    assert_eq!(line, 12);
    assert!(problem.contains("throne"), "{problem}");
    let (_, _, problem) = mistake(ROOM, "[[clutter]]\nkind = \"box\"\nat = \"A\"");
    assert!(problem.contains("size_in"), "{problem}");
}

#[test]
fn a_missing_file_says_which_worlds_there_are() {
    let error = World::open("no/such/world.toml").unwrap_err().to_string();
    assert!(
        error.contains("no/such/world.toml") && error.contains("living-room"),
        "{error}"
    );
}

#[test]
fn the_plan_is_north_up_and_the_start_is_the_origin() {
    // The robot faces east: the wall to its left, north of it, has negative X.
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
        Outline::Circle { .. } => false,
    });
    assert!(north, "{:?}", world.outlines());
}

#[test]
fn a_drop_closes_the_floor_and_its_edge_is_drawn() {
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

#[test]
fn generated_houses_are_sound_and_stay_the_same() {
    let mut texts = std::collections::BTreeSet::new();
    for seed in 1..=40 {
        let text = World::generated_text(seed);
        assert_eq!(text, World::generated_text(seed));
        let world = World::generated(seed);
        assert_eq!(world.name(), format!("generated:{seed}"));
        assert!(world.about().contains("rooms"), "seed {seed} is bare");
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
fn built_in_worlds_raise_no_warning() {
    for name in World::built_in_names() {
        let world = World::open(name).unwrap();
        assert_eq!(world.warnings(name), Vec::<String>::new());
    }
}

#[test]
fn what_the_robot_cannot_get_to_is_named() {
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
        warnings[0].starts_with("t.toml:11:3: the robot cannot get"),
        "{warnings:?}"
    );
    assert!(
        warnings[1].starts_with("t.toml:19:11: the lamp \"far\""),
        "{warnings:?}"
    );
    assert!(world.reach() < 0.5);
}

#[test]
fn a_picture_shows_what_is_there_and_explains_it() {
    let picture = World::open("flat").unwrap().picture();
    for line in [
        "  d dock",
        "  ~ no floor",
        "  x a black leg or caster",
        "  - a cord",
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
fn a_drawing_is_well_formed_to_the_last_tag() {
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
