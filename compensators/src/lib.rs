//! Compensation laws, one file each, over the core's trait. `no_std`: the same code runs in simulation and on the controller.
#![no_std]
