// All pages but the first one: one script, loaded after it.

export { NetworkPage } from '../network/network_page';
export { DrivePage } from '../pages/drive_page';
export { MapPage } from '../pages/map_page';
export { MessagesPage } from '../pages/messages_page';
export { PlotsPage } from '../pages/plots_page';
export { RobotPage } from '../pages/robot_page';
export { RecorderPage } from '../recorder/recorder_page';
export { SimulationPage } from '../simulation/simulation_page';
