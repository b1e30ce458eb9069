"""Events: functions whose sign change is an event, and its location within an interval."""
