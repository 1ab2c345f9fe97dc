"""What forces amount to: functions of a network and its forces."""
