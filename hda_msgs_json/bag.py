"""Recordings of topics: read as arrays, written so that ROS and its tools open them."""

from hda_msgs_json.bag_order import Message
from hda_msgs_json.bag_parts import TopicSummary
from hda_msgs_json.bag_reader import open_recording, Recording
from hda_msgs_json.bag_writer import BagWriter
from hda_msgs_json.mcap_records import BagError

__all__ = ['BagError', 'BagWriter', 'Message', 'open_recording', 'Recording', 'TopicSummary']
