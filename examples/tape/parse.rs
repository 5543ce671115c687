//! Parses tapes.
//!
//! ```text
//! size 120x40                  # columns and rows of the screen
//! world house seed 7
//! each 1.2s                    # duration of each picture of an animation
//! 4s picture
//! 9s key m p                   # one key after the other; Enter, Space, Esc, Tab, Up, Down, Left, Right by name
//! 9s type :mode home
//! 12s route 60,72 -42,84       # sends waypoints, inches
//! 12s caption It drives the route
//! ```

use std::str::FromStr;

use crossterm::event::KeyCode;
use groundwave_protocol::Waypoint;

/// A parsed tape.
#[derive(Debug, PartialEq)]
pub struct Tape {
    /// Columns and rows.
    pub size: (u16, u16),
    /// Name of a built-in world.
    pub world: String,
    /// Seed of the simulation.
    pub seed: u64,
    /// Duration of each picture, seconds.
    pub each_s: f64,
    /// Steps in order of their times.
    pub steps: Vec<Step>,
}

/// A step of a tape.
#[derive(Debug, PartialEq)]
pub struct Step {
    /// Virtual time since the start, seconds.
    pub at_s: f64,
    /// Its effect.
    pub act: Act,
}

/// The effect of a step.
#[derive(Debug, PartialEq)]
pub enum Act {
    /// Presses keys.
    Keys(Vec<KeyCode>),
    /// Sends a list of waypoints.
    Route(Vec<Waypoint>),
    /// Shows words below the following pictures.
    Caption(String),
    /// Takes a picture.
    Picture,
}

impl FromStr for Tape {
    type Err = String;

    /// Parses a tape; an error begins with the number of its line.
    fn from_str(text: &str) -> Result<Self, String> {
        let mut tape = Self {
            size: (120, 40),
            world: "house".to_owned(),
            seed: 1,
            each_s: 1.2,
            steps: Vec::new(),
        };
        for (number, line) in (1..).zip(text.lines()) {
            let line = line.split_once(" #").map_or(line, |(line, _)| line).trim();
            if !line.is_empty() && !line.starts_with('#') {
                tape.take(line)
                    .map_err(|problem| format!("{number}: {problem}"))?;
            }
        }
        if tape.steps.iter().any(|step| step.act == Act::Picture) {
            Ok(tape)
        } else {
            Err("1: no step takes a picture; add one such as `40s picture`".to_owned())
        }
    }
}

impl Tape {
    fn take(&mut self, line: &str) -> Result<(), String> {
        let (word, rest) = line.split_once(' ').unwrap_or((line, ""));
        let rest = rest.trim();
        match word {
            "size" => self.size = size(rest)?,
            "world" => (self.world, self.seed) = world(rest)?,
            "each" => self.each_s = seconds(rest)?,
            time => {
                let at_s = seconds(time)?;
                if self.steps.last().is_some_and(|last| last.at_s > at_s) {
                    return Err(format!("`{time}` is before the step above"));
                }
                let act = act(rest)?;
                self.steps.push(Step { at_s, act });
            }
        }
        Ok(())
    }
}

fn seconds(text: &str) -> Result<f64, String> {
    text.strip_suffix('s')
        .and_then(|number| number.parse().ok())
        .filter(|time: &f64| (0.0..=3600.0).contains(time))
        .ok_or_else(|| {
            format!("`{text}` is not a time such as `4.5s`, and not `size`, `world` or `each`")
        })
}

fn size(text: &str) -> Result<(u16, u16), String> {
    text.split_once('x')
        .and_then(|(columns, rows)| Some((columns.parse().ok()?, rows.parse().ok()?)))
        .ok_or_else(|| format!("`{text}` is not a size such as `120x40`"))
}

fn world(text: &str) -> Result<(String, u64), String> {
    text.split_once(" seed ")
        .and_then(|(name, seed)| Some((name.to_owned(), seed.parse().ok()?)))
        .ok_or_else(|| format!("`{text}` is not a world such as `house seed 7`"))
}

fn act(text: &str) -> Result<Act, String> {
    let (word, rest) = text.split_once(' ').unwrap_or((text, ""));
    match word {
        "key" if !rest.is_empty() => {
            let keys = rest.split_whitespace().map(key);
            keys.collect::<Result<_, _>>().map(Act::Keys)
        }
        "type" if !rest.is_empty() => Ok(Act::Keys(rest.chars().map(KeyCode::Char).collect())),
        "route" if !rest.is_empty() => {
            let points = rest.split_whitespace().map(point);
            points.collect::<Result<_, _>>().map(Act::Route)
        }
        "caption" => Ok(Act::Caption(rest.to_owned())),
        "picture" if rest.is_empty() => Ok(Act::Picture),
        _ => Err(format!(
            "`{text}` is not a step; steps are `key KEYS`, `type TEXT`, `route X,Y..`, `caption TEXT`, `picture`"
        )),
    }
}

fn key(name: &str) -> Result<KeyCode, String> {
    let mut letters = name.chars();
    Ok(match (name, letters.next(), letters.next()) {
        ("Enter", ..) => KeyCode::Enter,
        ("Space", ..) => KeyCode::Char(' '),
        ("Esc", ..) => KeyCode::Esc,
        ("Tab", ..) => KeyCode::Tab,
        ("Up", ..) => KeyCode::Up,
        ("Down", ..) => KeyCode::Down,
        ("Left", ..) => KeyCode::Left,
        ("Right", ..) => KeyCode::Right,
        (_, Some(letter), None) => KeyCode::Char(letter),
        _ => {
            return Err(format!(
                "`{name}` is not a key; write a letter, or Enter, Space, Esc, Tab, Up, Down, Left, Right"
            ));
        }
    })
}

fn point(text: &str) -> Result<Waypoint, String> {
    text.split_once(',')
        .and_then(|(x, y)| {
            Some(Waypoint {
                x_in: x.parse().ok()?,
                y_in: y.parse().ok()?,
            })
        })
        .ok_or_else(|| format!("`{text}` is not a waypoint such as `60,-12`"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tape_is_read() {
        let text = "# A tape\nsize 80x24\nworld flat seed 3\neach 0.5s\n\n\
                    1s key m Enter # prowl\n1s type :a b\n2.5s route 60,-12\n3s caption It is # one\n3s picture\n";
        let tape: Tape = text.parse().unwrap();
        assert_eq!(
            (tape.size, &tape.world[..], tape.seed),
            ((80, 24), "flat", 3)
        );
        let acts: Vec<&Act> = tape.steps.iter().map(|step| &step.act).collect();
        let typed = ":a b".chars().map(KeyCode::Char).collect();
        assert_eq!(
            acts,
            [
                &Act::Keys(vec![KeyCode::Char('m'), KeyCode::Enter]),
                &Act::Keys(typed),
                &Act::Route(vec![Waypoint {
                    x_in: 60,
                    y_in: -12
                }]),
                &Act::Caption("It is".to_owned()),
                &Act::Picture,
            ]
        );
    }

    #[test]
    fn mistakes_are_named_with_their_line() {
        for (text, said) in [
            ("size 80", "1: `80` is not a size"),
            ("\nworld house", "2: `house` is not a world"),
            ("4 picture", "1: `4` is not a time"),
            ("4s pictures", "1: `pictures` is not a step"),
            ("4s picture\n3s picture", "2: `3s` is before"),
            ("4s key Entr", "1: `Entr` is not a key"),
            ("4s route 1;2", "1: `1;2` is not a waypoint"),
            ("4s key p", "1: no step takes a picture"),
        ] {
            let problem = text.parse::<Tape>().unwrap_err();
            assert!(problem.starts_with(said), "{text}: {problem}");
        }
    }
}
