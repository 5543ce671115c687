//! The ground's estimate in the conventions of other programs.

use foxglove::messages::packed_element_field::NumericType;
use foxglove::messages::{
    FrameTransform, FrameTransforms, Grid, PackedElementField, PoseInFrame, Vector2,
};

use super::geometry::{M_PER_IN, MAP, ODOM, Place, odom, timestamp, upright};
use crate::estimate::{EstimateMessage, FloorKind, FloorMessage};

/// The corrected pose, and the transform by which the odometer is off; `None` while the heading is unknown.
pub(super) fn corrected(
    now_ns: u64,
    estimate: &EstimateMessage,
) -> Option<(PoseInFrame, FrameTransforms)> {
    let corrected = estimate.corrected?;
    let place = Place::of_inches(corrected.x_in, corrected.y_in, corrected.theta_deg);
    let believed = Place::of_inches(
        estimate.odometer_x_in,
        estimate.odometer_y_in,
        estimate.odometer_theta_deg,
    );
    let error = place.origin_of_frame_with(believed);
    let pose = PoseInFrame {
        timestamp: Some(timestamp(now_ns)),
        frame_id: MAP.to_owned(),
        pose: Some(place.pose()),
    };
    let transform = FrameTransform {
        timestamp: Some(timestamp(now_ns)),
        parent_frame_id: MAP.to_owned(),
        child_frame_id: ODOM.to_owned(),
        translation: Some(error.translation()),
        rotation: Some(error.rotation()),
    };
    let transforms = FrameTransforms {
        transforms: vec![transform],
    };
    Some((pose, transforms))
}

/// The floor as an occupancy grid with the values of ROS: -1 unknown, 0 free, 100 occupied. Its columns are along x, which is ahead,
/// and its rows along y, left. `None` for a damaged floor.
pub(super) fn grid(now_ns: u64, floor: &FloorMessage) -> Option<Grid> {
    let cells = floor.cells()?;
    let columns = floor.columns as usize;
    let occupancy = |kind: FloorKind| match kind {
        FloorKind::Unknown => -1_i8,
        FloorKind::Free => 0,
        FloorKind::Obstacle | FloorKind::Drop => 100,
    };
    // The robot's X grows to the right, y to the left.
    let columns_from_right = (0..columns).rev();
    let data = columns_from_right.flat_map(|column| {
        let along_x = cells.iter().skip(column).step_by(columns);
        along_x.map(|kind| occupancy(*kind).cast_unsigned())
    });
    let data: Vec<u8> = data.collect();
    let right_in = floor.corner_x_in + columns as f64 * floor.cell_in;
    let (x_m, y_m) = odom(right_in, floor.corner_y_in);
    let rows = (cells.len() / columns) as u32;
    let cell_m = floor.cell_in * M_PER_IN;
    Some(Grid {
        timestamp: Some(timestamp(now_ns)),
        frame_id: MAP.to_owned(),
        pose: Some(upright([x_m, y_m, 0.0])),
        column_count: rows,
        cell_size: Some(Vector2 {
            x: cell_m,
            y: cell_m,
        }),
        row_stride: rows,
        cell_stride: 1,
        fields: vec![PackedElementField {
            name: "occupancy".to_owned(),
            offset: 0,
            r#type: NumericType::Int8 as i32,
        }],
        data: data.into(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::CorrectedMessage;

    /// A robot that believes itself at (10, 20) in, heading right, and stands at (30, -40) in, heading left.
    #[test]
    fn transform_takes_the_believed_pose_to_the_corrected_one() {
        let estimate = EstimateMessage {
            odometer_x_in: 10.0,
            odometer_y_in: 20.0,
            odometer_theta_deg: 90.0,
            corrected: Some(CorrectedMessage {
                x_in: 30.0,
                y_in: -40.0,
                theta_deg: 270.0,
                ..CorrectedMessage::default()
            }),
        };
        let (pose, transforms) = corrected(7, &estimate).unwrap();
        let position = pose.pose.unwrap().position.unwrap();
        let close = |a: f64, b: f64| (a - b).abs() < 1e-9;
        assert!(close(position.x, -40.0 * M_PER_IN) && close(position.y, -30.0 * M_PER_IN));
        let transform = &transforms.transforms[0];
        let names = (&*transform.parent_frame_id, &*transform.child_frame_id);
        assert_eq!(names, ("map", "odom"));
        // Turned by half a circle: (20, -10) in odom is (-20, 10), and then shifted.
        let (shift, turn) = (transform.translation.unwrap(), transform.rotation.unwrap());
        assert!(close(turn.z.abs(), 1.0) && close(turn.w, 0.0), "{turn:?}");
        assert!(close(shift.x, (-40.0 + 20.0) * M_PER_IN), "{shift:?}");
        assert!(close(shift.y, (-30.0 - 10.0) * M_PER_IN), "{shift:?}");
        let unknown = EstimateMessage {
            corrected: None,
            ..estimate
        };
        assert_eq!(corrected(7, &unknown), None);
    }

    /// Two rows of three cells: an obstacle ahead on the left, free floor behind on the right.
    #[test]
    fn grid_is_ahead_and_left() {
        use FloorKind::{Drop, Free, Obstacle, Unknown};
        let cells = [Unknown, Unknown, Free, Obstacle, Drop, Unknown];
        let floor = FloorMessage::new((-6.0, 3.0), 3.0, 3, cells).unwrap();
        let grid = grid(7, &floor).unwrap();
        let values: Vec<i8> = grid.data.iter().map(|it| it.cast_signed()).collect();
        // From right to left, and in each row from behind ahead.
        assert_eq!(values, [0, -1, -1, 100, -1, 100]);
        assert_eq!((grid.column_count, grid.row_stride), (2, 2));
        let corner = grid.pose.unwrap().position.unwrap();
        assert_eq!((corner.x, corner.y), (3.0 * M_PER_IN, 0.0 - 3.0 * M_PER_IN));
    }
}
