//! Scans that the station sends by itself: at home, and near a destination.

use super::*;

/// A robot that prowls with every layer, and how far it is in a list.
fn prowling(list: ListPlace) -> Scene {
    let mut scene = scene();
    scene.state.mode = Mode::Prowl;
    scene.status.fitted = LayerMask::ALL;
    scene.status.allowed = LayerMask::ALL;
    scene.status.list = list;
    scene.hear_status();
    advised(scene, Advise::Auto)
}

/// Lines of a scan in the middle of a square room whose walls have echoes at a range.
fn scan(scene: &mut Scene, range_in: Option<u16>) {
    let begin_deg = scene.state.theta_deg;
    scene.state.layers.set(Layer::Rotation, LayerState::Holds);
    scene.state.rotation_in_s = 8;
    (scene.state.velocity_in_s, scene.state.bump) = (0, Bump::None);
    (scene.state.wheel_left_in_s, scene.state.wheel_right_in_s) = (4, -4);
    for step in 0..30 {
        scene.state.theta_deg = (begin_deg + step * 13) % 360;
        let off_deg = f64::from((scene.state.theta_deg + 45) % 90) - 45.0;
        let range_in = range_in.filter(|_| off_deg.abs() < 30.0);
        (scene.state.sonar_left_in, scene.state.sonar_right_in) = (range_in, range_in);
        assert_eq!(unasked_at_a_line(scene), []);
    }
    scene.state.theta_deg = begin_deg;
    scene.state.layers.set(Layer::Rotation, LayerState::Quiet);
    scene.state.rotation_in_s = 0;
}

/// A robot that drives home and is near it, and whose home was scanned where it began.
fn near_home() -> Scene {
    let mut scene = prowling(ListPlace::default());
    assert_eq!(unasked(&mut scene, 1), [Request::Scan]);
    scan(&mut scene, Some(155));
    assert_eq!(unasked(&mut scene, 1), []);
    assert!(scene.model.facts.ground.knows_home());

    drive_between_walls(&mut scene);
    scene.state.y_tenths_in = 500;
    scene.hear();
    send_home(&mut scene);
    assert_eq!(unasked(&mut scene, 1), [], "it is too far away");
    scene.state.y_tenths_in = 0;
    scene
}

/// Near home, scans at several places look for it until one shows it; the robot stays on its route.
#[test]
fn home_is_looked_for_where_it_is_believed() {
    for (range_in, looks) in [(Some(155), 1), (None, 2)] {
        let mut scene = near_home();
        for _ in 0..looks {
            assert_eq!(unasked(&mut scene, 1), [Request::Scan], "{range_in:?}");
            scan(&mut scene, range_in);
            assert_eq!(unasked(&mut scene, 1), [], "{range_in:?}");
            scene.state.y_tenths_in += 150;
        }
        let sent = unasked(&mut scene, 1);
        assert_eq!(sent == [Request::Scan], range_in.is_none(), "{sent:?}");
        assert!(logged(&scene, "plan home: looks around"));
    }
}

/// Where no scan on the way has shown home, the robot looks from places aside before it has arrived; it is not sent back on its way there.
#[test]
fn home_is_looked_for_from_aside() {
    let mut scene = near_home();
    assert_eq!(unasked(&mut scene, 1), [Request::Scan]);
    scan(&mut scene, None);
    let mut asides = 0;
    loop {
        end(&mut scene);
        let sent = unasked(&mut scene, 1);
        let [Request::Route(aside), Request::Mode(Mode::Prowl)] = &sent[..] else {
            assert_eq!(sent, []);
            break;
        };
        asides += 1;
        let end = aside.last().expect("a waypoint");
        let off_in = f64::from(end.x_in).hypot(f64::from(end.y_in));
        assert!(off_in > 15.0, "{end:?}");
        scene.state.mode = Mode::Prowl;
        drive_to(&mut scene, 0);
        assert_eq!(unasked(&mut scene, 50), [], "on its way");
        let late = unasked(&mut scene, 15);
        assert!(
            matches!(&late[..], [Request::Route(_)]),
            "it does not arrive: {late:?}"
        );
        drive_to(&mut scene, 0);
    }
    assert!((2..=4).contains(&asides), "{asides}");
    assert!(logged(&scene, "plan home: looks from aside"));
    assert!(logged(&scene, "plan home: arrived"));
}

/// No command hides that a STOP is not confirmed.
#[test]
fn nothing_is_sent_after_a_stop_that_failed() {
    let mut scene = prowling(ListPlace::default());
    let failed = CommandStatus::Failed(Failure::TimedOut);
    scene.command(2, Request::Stop, failed);
    assert_eq!(unasked(&mut scene, 120), []);
    scene.command(3, Request::Stop, CommandStatus::Confirmed { digest: None });
    assert_eq!(unasked(&mut scene, 120), [Request::Scan]);
}

/// A robot that drives another station's list is not kept from it by a scan.
#[test]
fn no_scan_interrupts_a_list_of_others() {
    for (driven, sent) in [(3, vec![]), (20, vec![Request::Scan])] {
        let mut scene = prowling(ListPlace { driven, count: 20 });
        assert_eq!(unasked(&mut scene, 1), sent, "{driven}");
    }
}

/// After STOP, home is not looked for.
#[test]
fn no_scan_is_sent_against_the_operator() {
    let mut scene = near_home();
    scene.command(2, Request::Stop, CommandStatus::Confirmed { digest: None });
    assert_eq!(unasked(&mut scene, 100), []);
}
