// The script of both pages: a replay, and the one in which a person drives.
if (document.getElementById('throttle')) require('./teleop.js');
else require('./main.js');
