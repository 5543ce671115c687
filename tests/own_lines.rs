//! Robots with lines of their own, on real links.
#![cfg(unix)]

use std::io::Write;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use portable_pty::{MasterPty, PtySize, native_pty_system};

use crate::programs::GROUNDWAVE;
use crate::pty::OnTerminal;

/// A robot on a pseudo-terminal that prints lines until it is dropped.
struct Robot {
    path: String,
    is_over: Arc<AtomicBool>,
    _master: Box<dyn MasterPty + Send>,
}

impl Robot {
    fn printing(line: impl Fn(u32) -> String + Send + 'static) -> Self {
        let pair = native_pty_system()
            .openpty(PtySize::default())
            .expect("a pseudo-terminal");
        let path = pair.master.tty_name().unwrap().display().to_string();
        let mut port = pair.master.take_writer().unwrap();
        let is_over = Arc::new(AtomicBool::new(false));
        let ended = Arc::clone(&is_over);
        thread::spawn(move || {
            // The open end keeps the device alive while nobody reads it.
            let _slave = pair.slave;
            for n in 0.. {
                if ended.load(Ordering::Relaxed) || port.write_all(line(n).as_bytes()).is_err() {
                    return;
                }
                thread::sleep(Duration::from_millis(50));
            }
        });
        Self {
            path,
            is_over,
            _master: pair.master,
        }
    }
}

impl Drop for Robot {
    fn drop(&mut self) {
        self.is_over.store(true, Ordering::Relaxed);
    }
}

#[test]
fn values_are_shown_without_a_configuration() {
    let robot = Robot::printing(|n| format!("temp:{}.5,volt:11.9\n", n % 3 + 20));
    let mut watch = OnTerminal::start(GROUNDWAVE, &["watch", &robot.path], 120, 40);
    watch.wait_for("the values", |text| {
        text.contains("F9 fields") && text.contains("volt             11.9")
    });
    watch.wait_for("another value", |text| {
        text.contains("temp             22.5")
    });
    assert!(
        !watch.text().contains("who holds the motors"),
        "{}",
        watch.text()
    );
    watch.type_keys("q");
    assert_eq!(watch.wait(), 0);
}
