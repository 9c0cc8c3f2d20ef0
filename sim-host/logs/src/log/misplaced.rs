//! Refusals of a log whose rows are whole and belong to another robot, another weld or another order:
//! found where logs are compared with the model, told at the log's file.

use super::Log;
use trueweld_plant::input::InputError;

impl Log {
    /// Refuses a log that is explained without columns of its wrench, and not with them: what is left of
    /// the tool's place with them and without, m.
    pub fn contradicted(&self, columns: &[&str], [with, without]: [f64; 2]) -> InputError {
        let columns = columns.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
        let message = format!(
            "{columns} load the arm otherwise than the tracker saw: {:.3} mm of the tool's place are left with them, \
             {:.3} mm without; expected a load that moves the arm as it was seen",
            1e3 * with,
            1e3 * without
        );
        let help = "No unit, sign or place of the sensor explains it. State what was measured under [columns] and [wrench], \
                    or leave the columns out.";
        self.source.error_of_file(message, help)
    }

    /// A tool seen so far, m RMS, from where the encoders put it, for no reason that is known.
    pub fn of_another_robot(&self, misfit: f64) -> InputError {
        let message = format!(
            "the tracker saw the tool {:.0} mm from where the encoders put it (root mean square), and no single mistake \
             explains that",
            1e3 * misfit
        );
        let help = "Are the robot file and the tracker's file those of this log? Of two mistakes at once, set right the one \
                    that you know. The frame of a tracker that stands elsewhere needs rows in several postures.";
        self.source.error_of_file(message, help)
    }

    /// A tool so far, m, from the seam that the log names.
    pub fn of_another_weld(&self, away: f64) -> InputError {
        let message = format!(
            "the tool is {:.0} mm from the seam that `weld` names; expected a log of that weld",
            1e3 * away
        );
        let help =
            "Is `weld` in log.toml that of another log? A seam is given in the robot's base.";
        self.source.error_of_file(message, help)
    }

    /// A tool that went so far, m, from the end of the seam towards its start.
    pub fn against_its_weld(&self, travel: f64) -> InputError {
        let message = format!(
            "the tool went {:.0} mm from the seam's end towards its start; expected a weld from `start_m` to `end_m`",
            1e3 * travel
        );
        let help = "Are `start_m` and `end_m` exchanged in the file that `weld` names? The advancing side changes with them. \
                    Or were the rows read backwards?";
        self.source.error_of_file(message, help)
    }

    /// A tool that pressed so far, m, from the surface that the log's weld states.
    pub fn off_its_surface(&self, far: f64) -> InputError {
        let message = format!(
            "pressing, the tool was seen up to {:.0} mm from the surface that `weld` states; expected it in the plate",
            1e3 * far
        );
        let help = "Are the points, the tool axis or the normals, and the part's place in the file that `weld` names those of this \
                    plate? They are given in the robot's base.";
        self.source.error_of_file(message, help)
    }

    /// Rows in which friction drives the arm.
    pub fn backwards(&self) -> InputError {
        let message = "by the motor torques this motion was read backwards: friction drives the arm; expected the rows in \
                       the order in which they were recorded";
        let help = "Was the file sorted, or the time column written anew?";
        self.source.error_of_file(message, help)
    }
}
