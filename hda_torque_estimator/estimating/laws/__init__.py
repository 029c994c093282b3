"""The compiled laws of one sample: torque, force, contact, payload, and what is believed."""
